#pragma once

#include <optional>
#include <string>

#include "common/geometry/se3.hpp"

namespace headframe {

/// Where a robot is now, and its condition. It is never stored: each state replaces the one before.
struct LiveState {
  double stamp_s = 0;                                 // by the robot's clock
  std::optional<Pose> T_local_sensor = std::nullopt;  // nullopt: it does not know where it is
  std::optional<double> battery = std::nullopt;       // 0: empty, 1: full
  std::string health = {};                            // for people, at most limits::health_bytes; empty: none
};

}  // namespace headframe
