#pragma once
// What a descriptor needs where there is no roof: underground everything is near and all around, outdoors little is.

#include "common/descriptor/family.hpp"
#include "common/descriptor/range_image.hpp"

namespace headframe {

/// How far the sky is open, 0 to 1: from the share of azimuths where more than half of what is above the horizon is
/// empty, ahead and behind. (A lidar off level sees nothing there on one side only.) 0 underground. The image's rows
/// are to lie about the horizon, its columns are to be even in number.
double openness(const RangeImage& image);

constexpr std::size_t open_sky_q_size = 60;

/// Adds to a network's descriptor what the handcrafted families know of an open place: open_sky_q_size numbers of Scan
/// Context's ring key and LiDAR-Iris' energies at the end of q, in a scale where they weigh as much as a q of length
/// one, and Scan Context's sector key into w. Both times `open` (openness()): at 0 the numbers are zero and w stays.
Result<void> add_open_sky(Descriptor& descriptor, const Points& points_level, double open);

}  // namespace headframe
