#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Where the robot is in the map of others, as the base station told it, or what is missing.
struct Localization {
  enum class State {
    not_yet,     // nothing is told, or no more what had been: whoever drives by it stops
    found,       // as sure as a transform of a merged map
    unsupported  // this base station is older than the question; another one may know it
  };
  State state = State::not_yet;
  std::uint64_t keyframe = 0;  // the newest that the answer is made of; 0: none

  // Where it is; only if found. The component's frame is the local frame of its anchor.
  std::uint64_t component = 0;
  SessionKey anchor = {};
  Pose T_component_session = Pose::Identity();  // where the robot is now: this times its T_local_sensor
  Pose T_component_sensor = Pose::Identity();   // of `keyframe`
  /// Of T_component_sensor: x, y, z in metres, then rotations about the component's axes x, y, z in radians.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  SessionKey session = {};  // of the map, the one that speaks for it most
  bool merged = false;      // it is part of the map for all robots, and in Transforms

  double probability = 0;    // of the best placement there is
  double shared_m = 0;       // path that the robot shares with the map there
  double awaited_m = 0;      // path to drive on, at least, before it can be told; 0: nobody knows
  double look_alikes = 0;    // other places that look as the best one does
  std::string missing = {};  // why it is not found, and what helps
};

}  // namespace headframe
