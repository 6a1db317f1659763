#pragma once
// New poses of earlier keyframes, as messages. Pure and thread safe.

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe_pose.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// One message's part of an update.
struct PoseUpdatePart {
  std::uint64_t number = 0;
  std::size_t total_poses = 0;  // of the whole update
  std::size_t offset = 0;       // number of poses in the messages before
  std::vector<KeyframePose> poses;
};

/// The poses need rising sequences; they are sent in as few runs as possible.
v1::PoseUpdate to_proto(std::uint64_t number, std::size_t total_poses, std::size_t offset,
                        std::span<const KeyframePose> poses);

/// The result has a number and 1 to limits::part_poses valid poses of rising sequences from 1 on, no more than remain
/// of an update of at most limits::update_poses. bad_input: anything else.
Result<PoseUpdatePart> from_proto(const v1::PoseUpdate& message);

/// The same without limits on the number of poses, for what this program wrote to its own disk.
Result<std::vector<KeyframePose>> poses_of(const v1::PoseUpdate& message);

}  // namespace headframe
