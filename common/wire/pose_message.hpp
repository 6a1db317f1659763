#pragma once
// New poses of keyframes that were sent before, as messages. Pure and thread safe.

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe_pose.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// One message's share of an update.
struct PoseUpdatePart {
  std::uint64_t number = 0;
  std::size_t total_poses = 0;  // of the whole update
  std::size_t offset = 0;       // poses in the messages before
  std::vector<KeyframePose> poses;
};

/// Poses of rising sequences, in as few runs as can be.
v1::PoseUpdate to_proto(std::uint64_t number, std::size_t total_poses, std::size_t offset,
                        std::span<const KeyframePose> poses);

/// What it returns has a number, 1 to limits::part_poses sound poses of rising sequences from 1 on, and is no more than
/// is left of a whole of at most limits::update_poses. bad_input: it is none.
Result<PoseUpdatePart> from_proto(const v1::PoseUpdate& message);

/// The same without bounds on how many there are: of what this program wrote to its own disk.
Result<std::vector<KeyframePose>> poses_of(const v1::PoseUpdate& message);

}  // namespace headframe
