#pragma once
// Where could one stretch of walls lie on another, over all shifts and turns? Coarse by FFT; WallField refines what is
// worth it.

#include "server/place/wall_field.hpp"

namespace headframe {

/// How closely all placements are tried.
struct WallSearchSteps {
  float cell_m = 1.5F;             // of the maps as they are redrawn
  std::size_t quarter_turns = 45;  // turns in a right angle: the four quarters share their drawings
  std::size_t peaks = 200;         // kept of each turn: a mine of parallel galleries fits at scores of shifts
};

/// The best `most` distinct placements (4 m or 12 deg apart), best first, over all shifts and turns. Scores are of the
/// maps as they are redrawn. The grid is cyclic and smaller than both maps side by side:
/// of the shifts that fall on one cell, most of which hardly bring the maps together, the one that `field` of a scores
/// best counts. Independent of the thread count. After correlative scan matching (Olson, ICRA 2009), with free space
/// held against walls.
std::vector<WallMatch> search_walls(const WallMap& a, const WallField& field, const WallMap& b, std::size_t most,
                                    const WallSearchSteps& steps, int threads);

}  // namespace headframe
