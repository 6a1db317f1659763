#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// The near-horizontal walls and the free ground of a stretch of one session, seen from above, drawn from the wall
/// profiles of its keyframes, so from the thin link alone. Cell centres in the session's frame, metres.
struct WallMap {
  std::vector<Eigen::Vector2f> walls;
  std::vector<Eigen::Vector2f> free;
  float cell_m = 1;
};

/// Walls up to 30 m and free rays up to 20 m from each keyframe.
WallMap draw_wall_map(std::span<const Keyframe> keyframes, float cell_m);

}  // namespace headframe
