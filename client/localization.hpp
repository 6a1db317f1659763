#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Where the robot is in the map of others, as the base station reported it, or what is missing.
struct Localization {
  enum class State {
    not_yet,     // nothing was reported, or an earlier answer was withdrawn: the robot must not rely on it
    found,       // as sure as a transform of a merged map
    unsupported  // this base station does not know the question; a newer one may
  };
  State state = State::not_yet;
  std::uint64_t keyframe = 0;  // the newest keyframe that the answer is based on; 0: none

  // Where it is; only if found. The component's frame is the local frame of its anchor.
  std::uint64_t component = 0;
  SessionKey anchor = {};
  Pose T_component_session = Pose::Identity();  // times its T_local_sensor: the robot's present pose
  Pose T_component_sensor = Pose::Identity();   // of `keyframe`
  /// Of T_component_sensor: x, y, z in metres, then rotations about the component's axes x, y, z in radians.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  SessionKey session = {};  // the session of the map that supports it most
  bool merged = false;      // the robot's session belongs to the map for all robots, and appears in Transforms

  double probability = 0;    // of the best placement
  double shared_m = 0;       // path that the robot shares with the map at that placement
  double awaited_m = 0;      // path still to be driven, at least, before an answer is possible; 0: unknown
  double look_alikes = 0;    // number of other places that look like the best one
  std::string missing = {};  // why it is not found, and what would help
};

}  // namespace headframe
