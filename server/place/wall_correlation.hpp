#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/place/wall_search.hpp"

namespace headframe {

/// Where b could lie on a: turn b by yaw, then shift it.

/// The best `most` distinct placements (5 m or 20 deg apart), best first, over all shifts and 2 deg turns, by FFT; the
/// best hundred are refined to half a cell and 1 deg. Both maps must have the same cell_m. Independent of the thread
/// count. After correlative scan matching (Olson, ICRA 2009), with free space held against walls.
std::vector<WallMatch> correlate(const WallMap& a, const WallMap& b, std::size_t most, int threads);

/// The best placement within two cells and 4 deg of a guess that came from elsewhere, with its score.
WallMatch refine_old(const WallMap& a, const WallMap& b, const WallMatch& guess);

}  // namespace headframe
