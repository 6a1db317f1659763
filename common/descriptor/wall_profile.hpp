#pragma once

#include <cstdint>

#include "common/cloud/point_cloud.hpp"
#include "common/session/keyframe.hpp"

namespace headframe {

/// Distance to the wall in every 2 degree sector, from the beams within 4.5 deg of the horizon (points_level: levelled
/// sensor frame, finite). Sector i covers azimuths [2i, 2i + 2) deg, counted from x towards y.
WallProfile wall_profile(const Points& points_level);

/// Codes are logarithmic: 0.3 m to 120 m in 254 steps of 2.4 %. 0 means no return.
std::uint8_t encode_wall_range(float range_m);
float decode_wall_range_m(std::uint8_t code);

}  // namespace headframe
