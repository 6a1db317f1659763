#pragma once
// Where could one stretch of walls lie on another, over all shifts and turns? Coarse by FFT; WallField refines what is
// worth it.

#include "server/place/wall_field.hpp"

namespace headframe {

/// The best `most` distinct placements (4 m or 12 deg apart), best first, over all shifts and 180 turns, of maps
/// redrawn with cells of 1.5 m. Scores are of that drawing. The grid is cyclic and smaller than both maps side by side:
/// of the shifts that fall on one cell, most of which hardly bring the maps together, the one that `field` of a scores
/// best counts. Independent of the thread count. After correlative scan matching (Olson, ICRA 2009), with free space
/// held against walls.
std::vector<WallMatch> search_walls(const WallMap& a, const WallField& field, const WallMap& b, std::size_t most,
                                    int threads);

}  // namespace headframe
