#pragma once
// What the network `learned` looks at: the same in training and on a robot.

#include "common/descriptor/range_image.hpp"

namespace headframe {

/// points_level: levelled sensor frame, finite. 16 rows within 11.2 deg of the horizon, small holes filled.
inline RangeImage learned_input(const Points& points_level) {
  RangeImage image = range_image(points_level, RangeImageSpec{});
  fill_small_holes(image, 2, 4);
  return image;
}

}  // namespace headframe
