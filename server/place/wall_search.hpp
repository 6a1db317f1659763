#pragma once
// Searches over all shifts and rotations for placements of one wall map on another, coarsely by FFT. WallField refines
// promising results.

#include "server/place/wall_field.hpp"

namespace headframe {

/// The resolution of the search.
struct WallSearchSteps {
  float cell_m = 1;                // of the maps as redrawn for the search
  std::size_t quarter_turns = 45;  // rotations per right angle; the four quarters share their drawings
  std::size_t peaks = 100;         // kept for each rotation: in a mine of parallel galleries many shifts fit
  float penalty = 5;               // for a wall on free ground, relative to wall on wall; 3 in cells of 1.5 m and more
};

/// The best `most` distinct placements (4 m or 12 deg apart) over all shifts and rotations, best first. Scores refer to
/// the redrawn maps. The grid is cyclic and smaller than both maps side by side, so several shifts share a cell; of
/// these, most of which hardly make the maps overlap, the one that `field` of a scores best is used. Independent of the
/// thread count. Based on correlative scan matching (Olson, ICRA 2009); in addition, free space that meets walls counts
/// against a placement.
std::vector<WallMatch> search_walls(const WallMap& a, const WallField& field, const WallMap& b, std::size_t most,
                                    const WallSearchSteps& steps, int threads);

}  // namespace headframe
