#pragma once
// Where could one stretch of walls lie on another, over all shifts and turns? Coarse by FFT, then fine where it is
// worth it.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "server/place/wall_map.hpp"

namespace headframe {

/// Where b could lie on a: turn b by yaw, then shift it.
struct WallMatch {
  double yaw_rad = 0;
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();
  double score = 0;  // cells of wall on wall (3x3 smear), less 3 for each wall on free, both ways
};

/// The best `most` distinct placements (4 m or 12 deg apart), best first, over all shifts and 180 turns, of maps
/// redrawn with cells of 1.5 m. Scores are of that drawing. Independent of the thread count. After correlative scan
/// matching (Olson, ICRA 2009), with free space held against walls.
std::vector<WallMatch> search_walls(const WallMap& a, const WallMap& b, std::size_t most, int threads);

/// A map as a grid, to score placements of others on it. Immutable; thread safe.
class WallField {
 public:
  explicit WallField(const WallMap& map);

  double score(const WallMap& b, const WallMatch& placement) const;

  /// coarse: the best within +-3 m and +-4 deg of the guess in steps of 1 m and 2 deg, by a third of the cells. fine:
  /// within 1.25 m and 2 deg, to half a cell and 1 deg. Both give the score of all cells.
  enum class Step { coarse, fine };
  WallMatch refine(const WallMap& b, const WallMatch& guess, Step step) const;

 private:
  struct Cell {
    std::int8_t for_wall = 0, for_free = 0;
  };
  int score(const WallMap& b, const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift, std::size_t every) const;

  float cell_m_;
  Eigen::Vector2f low_;
  int columns_ = 0, rows_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace headframe
