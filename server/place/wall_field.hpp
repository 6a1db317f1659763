#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
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

/// What a placement of b on a amounts to, in cells.
struct WallFit {
  int met = 0;                                       // walls of b on walls of a (3x3 smear)
  int contradicted = 0;                              // walls where the other map is free, both ways
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // of the walls of b that met, in b's frame

  double score() const { return met - static_cast<double>(wall_penalty) * contradicted; }
  /// A short overlap without contradictions beats a long one with some: right placements have few however long they
  /// are.
  double strict() const { return met - 10.0 * contradicted; }
};

/// A part of a map that lies within radius_m of a point of its frame.
struct Surroundings {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0;
};

/// A map as a grid, to score placements of others on it. Immutable; thread safe.
class WallField {
 public:
  explicit WallField(const WallMap& map);

  WallFit fit(const WallMap& b, const WallMatch& placement,
              const std::optional<Surroundings>& within = std::nullopt) const;
  std::size_t bytes() const { return cells_.size() * sizeof(Cell) + reach_.size(); }

  /// coarse: the best within +-6 cells and +-4 deg of the guess in steps of 2 cells and 2 deg, by some hundred of b's
  /// cells. fine: within 2.5 cells and 2 deg, to half a cell and 1 deg, by all of them. Only cells of b that the guess
  /// brings near to what a knows take part, turns are about their middle, and `within` restricts them further. Both
  /// give the score of all cells.
  enum class Step { coarse, fine };
  WallMatch refine(const WallMap& b, const WallMatch& guess, Step step,
                   const std::optional<Surroundings>& within = std::nullopt) const;

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
  void mark_reach();
  WallMap near_part(const WallMap& b, const WallMatch& guess, const std::optional<Surroundings>& within) const;
  Best best_within(const WallMap& b, const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift, Window window,
                   std::size_t every) const;

  float cell_m_;
  Eigen::Vector2f low_;
  int columns_ = 0, rows_ = 0;
  std::vector<Cell> cells_;
  int reach_columns_ = 0;
  std::vector<std::uint8_t> reach_;  // blocks of cells that hold something, or whose neighbours do
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
