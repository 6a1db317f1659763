#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/place/wall_cells.hpp"
#include "server/place/wall_map.hpp"

namespace headframe {

inline constexpr float wall_penalty = 3;  // for a wall where the other map is free, relative to wall on wall

/// A placement of b on a: rotate b by yaw, then shift it.
struct WallMatch {
  double yaw_rad = 0;
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();
  double score = 0;  // wall cells that meet walls (3x3), minus 3 for each on free ground, both ways
};

/// How well a placement of b on a fits, in cells.
struct WallFit {
  int met = 0;                                       // walls of b that meet walls of a (within 3x3)
  int contradicted = 0;                              // walls where the other map is free, both ways
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // of the walls of b that met, in b's frame

  double score() const { return met - static_cast<double>(wall_penalty) * contradicted; }
  /// For placements that are not refined yet: half a coarse cell off, a right one has many contradictions.
  int lenient() const { return met - contradicted; }
  /// Ranks a short overlap without contradictions above a long one with some; right placements have few at any length.
  double strict() const { return met - 10.0 * contradicted; }
  /// 0 to 1. Right placements contradict less than wrong ones, whatever their length; a few cells tell little.
  double contradiction() const { return contradicted / (met + contradicted + 20.0); }
};

/// A part of a map that lies within radius_m of a point of its frame.
struct Surroundings {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0;
};

/// A map as a grid, for scoring placements of other maps on it. Immutable; thread safe.
class WallField {
 public:
  explicit WallField(const WallMap& map);

  WallFit fit(const WallMap& b, const WallMatch& placement,
              const std::optional<Surroundings>& within = std::nullopt) const;
  /// fit().score()
  double score(const WallMap& b, const WallMatch& placement) const;
  std::size_t bytes() const { return for_wall_.size() + for_free_.size() + reach_.size(); }

  /// Searches for the best placement near the guess. coarse: within +-6 cells and +-4 deg in steps of 2 cells and 2
  /// deg, using some hundred of b's cells. fine: within 2.5 cells and 2 deg, to half a cell and 1 deg, using all of
  /// them. Only cells of b that the guess brings near to known cells of a are used; rotations are about their middle,
  /// and `within` restricts them further. The result has no score: see fit() and score().
  enum class Step { coarse, fine };
  WallMatch refine(const WallMap& b, const WallMatch& guess, Step step,
                   const std::optional<Surroundings>& within = std::nullopt) const;

 private:
  struct Best {
    int score;
    Eigen::Vector2i cells;  // offset from the placement
  };
  void mark_reach();
  WallMap near_part(const WallMap& b, const WallMatch& guess, const std::optional<Surroundings>& within) const;
  OnGrid on_grid(const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift) const;
  OnGrid on_grid(const WallMatch& m) const {
    return on_grid(Eigen::Rotation2Df(static_cast<float>(m.yaw_rad)).toRotationMatrix(), m.shift_m.cast<float>());
  }
  Best best_within(const WallMap& b, const OnGrid& grid, CellWindow window, std::size_t every) const;
  template <class Act>
  static void look_up(std::span<const Eigen::Vector2f> points, const OnGrid& grid, const CellWorth& worth, Act&& act);

  float cell_m_;
  Eigen::Vector2f low_;
  int columns_ = 0, rows_ = 0;
  CellWorth for_wall_, for_free_;  // what a wall of b, and free ground of b, is worth there
  int reach_columns_ = 0;
  std::vector<std::uint8_t> reach_;  // blocks of cells that are not empty, or have a neighbour that is not; then a 0
};

/// The bounding box of a map's cells.
struct WallBox {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9F), high = Eigen::Vector2f::Constant(-1e9F);
  explicit WallBox(const WallMap& map);
  Eigen::Vector2f middle() const { return (low + high) / 2; }
};

/// Where a placement of b moves the point `middle` of b.
Eigen::Vector2d middle_at(const WallMatch& placement, const Eigen::Vector2d& middle);

}  // namespace headframe
