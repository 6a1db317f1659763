#pragma once

#include <cstdint>
#include <optional>
#include <unordered_set>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Which walls of a component were seen from nearby, from the wall profiles of keyframes. Not thread safe.
class SeenRock {
 public:
  static constexpr double reach_m = 12;   // walls farther away belong to the next keyframe
  static constexpr int least_walls = 20;  // directions with a wall within reach; with fewer there is no answer

  /// T_component_sensor: of the keyframe with these walls.
  void add(const Pose& T_component_sensor, const WallProfile& walls);

  /// Of the walls within reach of a keyframe, the share that lies within about half a metre of walls that were added;
  /// nullopt if there are too few.
  std::optional<double> share_seen(const Pose& T_component_sensor, const WallProfile& walls) const;

 private:
  std::unordered_set<std::uint64_t> cells_;
};

}  // namespace headframe
