#pragma once
// Extends a descriptor for places without a roof: underground, surfaces are near and all around; outdoors there are
// few.

#include "common/descriptor/family.hpp"
#include "common/descriptor/range_image.hpp"

namespace headframe {

/// How open the sky is, 0 to 1: from the share of azimuths in which more than half of the image above the horizon is
/// empty both ahead and behind. (A tilted lidar sees nothing there on one side only.) 0 underground. The image's rows
/// have to span the horizon, and its number of columns has to be even.
double openness(const RangeImage& image);

constexpr std::size_t open_sky_q_size = 60;

/// Adds features of the handcrafted families to a network's descriptor: open_sky_q_size numbers from Scan Context's
/// ring key and LiDAR-Iris' energies at the end of q, scaled to have the same weight as a q of length one, and Scan
/// Context's sector key into w. Both are multiplied by `open` (openness()): at 0 the numbers are zero and w stays the
/// same.
Result<void> add_open_sky(Descriptor& descriptor, const Points& points_level, double open);

}  // namespace headframe
