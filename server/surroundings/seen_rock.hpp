#pragma once

#include <cstdint>
#include <optional>
#include <unordered_set>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Which walls of a component were seen from near by, as the wall profiles of keyframes tell them. Not thread safe.
class SeenRock {
 public:
  static constexpr double reach_m = 12;   // walls farther off are the next keyframe's
  static constexpr int least_walls = 20;  // directions with a wall within reach; with fewer nothing is said

  /// T_component_sensor: of the keyframe whose walls these are.
  void add(const Pose& T_component_sensor, const WallProfile& walls);

  /// Of the walls within reach of a keyframe, the share that lies within half a metre or so of some that were added;
  /// none: it has too few.
  std::optional<double> share_seen(const Pose& T_component_sensor, const WallProfile& walls) const;

 private:
  std::unordered_set<std::uint64_t> cells_;
};

}  // namespace headframe
