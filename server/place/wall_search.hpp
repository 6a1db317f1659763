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

/// A map as a grid, to score placements of others on it. Immutable; thread safe.
class WallField {
 public:
  explicit WallField(const WallMap& map);

  double score(const WallMap& b, const WallMatch& placement) const;

  /// coarse: the best within +-6 cells and +-4 deg of the guess in steps of 2 cells and 2 deg, by a third of b's cells.
  /// fine: within 2.5 cells and 2 deg, to half a cell and 1 deg. Both give the score of all cells.
  enum class Step { coarse, fine };
  WallMatch refine(const WallMap& b, const WallMatch& guess, Step step) const;

 private:
  struct Cell {
    std::int8_t for_wall = 0, for_free = 0;
  };
  /// Cells of a that are tried around a placement: -reach to reach on both axes, `stride` apart.
  struct Window {
    int reach = 0, stride = 1;
  };
  struct Best {
    int score;
    Eigen::Vector2i cells;  // from the placement
  };
  Best best_within(const WallMap& b, const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift, Window window,
                   std::size_t every) const;

  float cell_m_;
  Eigen::Vector2f low_;
  int columns_ = 0, rows_ = 0;
  std::vector<Cell> cells_;
};

/// The best `most` distinct placements (4 m or 12 deg apart), best first, over all shifts and 180 turns, of maps
/// redrawn with cells of 1.5 m. Scores are of that drawing. The grid is cyclic and smaller than both maps side by side:
/// of the shifts that fall on one cell, most of which hardly bring the maps together, the one that `field` of a scores
/// best counts. Independent of the thread count. After correlative scan matching (Olson, ICRA 2009), with free space
/// held against walls.
std::vector<WallMatch> search_walls(const WallMap& a, const WallField& field, const WallMap& b, std::size_t most,
                                    int threads);

}  // namespace headframe
