#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// The nearly horizontal walls and the free ground of a stretch of one session, seen from above. Drawn from the
/// keyframes' wall profiles alone, so it needs no point clouds. Cell centres in the session's frame, metres.
struct WallMap {
  std::vector<Eigen::Vector2f> walls;
  std::vector<Eigen::Vector2f> free;
  float cell_m = 1;
};

/// Draws walls up to 30 m and free rays up to 20 m from each keyframe.
WallMap draw_wall_map(std::span<const Keyframe> keyframes, float cell_m);

}  // namespace headframe
