#pragma once

#include <cstdint>

#include "common/geometry/se3.hpp"

namespace headframe {

/// The pose of a keyframe of a session.
struct KeyframePose {
  std::uint64_t sequence = 0;
  Pose T_local_sensor = Pose::Identity();
};

}  // namespace headframe
