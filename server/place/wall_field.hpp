#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "server/place/wall_map.hpp"

namespace headframe {

inline constexpr float wall_penalty = 3;  // of a wall where the other map is free, against a wall on a wall

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
  std::size_t bytes() const { return cells_.size() * sizeof(Cell); }

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

/// Around all cells of a map.
struct WallBox {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9F), high = Eigen::Vector2f::Constant(-1e9F);
  explicit WallBox(const WallMap& map);
  Eigen::Vector2f middle() const { return (low + high) / 2; }
};

/// Where a placement of b puts its middle.
Eigen::Vector2d middle_at(const WallMatch& placement, const Eigen::Vector2d& middle);

}  // namespace headframe
