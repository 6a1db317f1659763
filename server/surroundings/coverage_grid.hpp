#pragma once

#include <Eigen/Core>
#include <map>
#include <set>
#include <utility>

#include "common/coverage/coverage_tile.hpp"
#include "common/session/keyframe.hpp"

namespace headframe {

/// What was seen of a component, as a map from above in its frame. The same keyframes in any order give the same grid.
/// Not thread safe.
class CoverageGrid {
 public:
  /// Drops what would need more than most_tiles tiles; then full() is true.
  explicit CoverageGrid(std::size_t most_tiles) : most_tiles_(most_tiles) {}

  /// Adds the free space and walls around a keyframe, from its wall profile, up to coverage_range_m.
  void see(std::uint32_t session, const Pose& T_component_sensor, double stamp_s, const WallProfile& walls);
  /// Adds a straight path of the sensor from one place to the other.
  void walk(std::uint32_t session, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, double stamp_s);

  const std::map<TileIndex, CoverageTile>& tiles() const { return tiles_; }
  bool full() const { return full_; }
  /// The tiles that changed since the last call.
  std::set<TileIndex> take_changed() { return std::exchange(changed_, {}); }

 private:
  void mark(const Eigen::Vector2d& p_m, std::uint8_t what, std::uint32_t session, std::int32_t time);

  std::size_t most_tiles_;
  std::map<TileIndex, CoverageTile> tiles_;
  std::set<TileIndex> changed_;
  bool full_ = false;
};

}  // namespace headframe
