#pragma once
// The answer to a robot that asks where it is.

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/geometry/se3.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Where a session lies in a map, or why that is not known yet. The component's frame is that of its anchor.
struct SessionLocalization {
  bool found = false;
  bool merged = false;      // the session belongs to the component; false: nothing was merged because of the question
  SessionId component = 0;  // of the map; 0 while nothing is found
  SessionId on = 0;         // the session of the map that supports it most; 0: none
  std::uint64_t keyframe = 0;  // the newest keyframe of the session that was considered; 0: none
  Pose T_component_session = Pose::Identity();
  Pose T_component_sensor = Pose::Identity();  // of that keyframe
  /// Of T_component_sensor: x, y, z in metres, then rotations about the component's axes x, y, z in radians.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double probability = 0;    // of the best placement
  double shared_m = 0;       // path that the session shares with the map at that placement
  double awaited_m = 0;      // path still to be driven, at least, before the best placement can be reported; 0: unknown
  double look_alikes = 0;    // number of other places that look like the best one
  std::string missing = {};  // why it is not found, and what would help; empty if found

  bool operator==(const SessionLocalization& other) const;
};

}  // namespace headframe
