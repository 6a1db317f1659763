#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "server/session/ids.hpp"

namespace headframe {

/// A place of a session that fits at another place of it, too. Positions are in the session's local frame.
struct LikePlace {
  Eigen::Vector3d here = Eigen::Vector3d::Zero(), there = Eigen::Vector3d::Zero();
  std::uint32_t placement = 0;  // of the session on itself; what is longer than a place fits at several places
  double likeness = 0;          // as a copy of the rock would, 0 to 1: see likeness()
  double resemblance = 0;       // see resemblance()
  bool copy = false;            // it fits for 15 m and more

  bool operator==(const LikePlace&) const = default;
};

/// How often a session looks like itself at other places, and the data that this was found from.
struct SelfLikeness {
  double path_m = -1;               // length of the session then; negative: never searched
  std::size_t clouds = 0;           // number stored then
  double aliases = 0;               // see Evidence::aliases
  double look_alikes = 0;           // see Evidence::look_alikes
  double similar_places = 0;        // see Evidence::similar_places
  std::vector<LikePlace> places;    // which the last three count; empty if found by a version that did not say where
  std::vector<KeyframeRef> wanted;  // clouds that would allow a closer look at places whose walls look alike

  bool operator==(const SelfLikeness&) const = default;
};

}  // namespace headframe
