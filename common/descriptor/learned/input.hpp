#pragma once
// The input of the network `learned`, the same in training and on a robot.

#include "common/descriptor/network_image.hpp"

namespace headframe {

/// points_level: levelled sensor frame, finite. 16 rows within 11.2 deg of the horizon, small holes filled.
inline RangeImage learned_input(const Points& points_level) { return NetworkImage{}.draw(points_level); }

}  // namespace headframe
