#pragma once
// What a robot is told that asks where it is.

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/geometry/se3.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Where a session lies in a map, or why that can not be told yet. The component's frame is that of its anchor.
struct SessionLocalization {
  bool found = false;
  bool merged = false;         // the session is part of the component for all robots; else nothing was merged for this
  SessionId component = 0;     // of the map; 0 while nothing is found
  SessionId on = 0;            // the session of the map that speaks for it most; 0: none does
  std::uint64_t keyframe = 0;  // the session's newest that was looked at; 0: none
  Pose T_component_session = Pose::Identity();
  Pose T_component_sensor = Pose::Identity();  // of that keyframe
  /// Of T_component_sensor: x, y, z in metres, then rotations about the component's axes x, y, z in radians.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double probability = 0;  // of the best placement there is
  double shared_m = 0;     // path that the session shares with the map there
  double awaited_m = 0;  // path that it has to come along at least before the best placement could be told; 0: unknown
  double look_alikes = 0;    // other places that look as the best one does
  std::string missing = {};  // why it is not found, and what helps; empty: it is found

  bool operator==(const SessionLocalization& other) const;
};

}  // namespace headframe
