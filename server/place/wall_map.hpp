#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// The near-horizontal walls and the free ground of a stretch of one session, seen from above, drawn from the wall profiles
/// of its keyframes (so from the thin link alone). Cell centres in the session's frame, metres.
struct WallMap {
  std::vector<Eigen::Vector2f> walls;
  std::vector<Eigen::Vector2f> free;
  float cell_m = 0;
};

WallMap draw_wall_map(std::span<const Keyframe> keyframes, float cell_m);

/// Where b could lie on a: turn b by yaw, then shift it.
struct WallMatch {
  double yaw_rad = 0;
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();
  double score = 0;  // cells of wall on wall (3x3 smear), less 3 for each wall on free, both ways
};

/// The best `most` distinct placements (5 m or 20 deg apart), best first, over all shifts and 2 deg turns, by FFT; then
/// each is refined to half a cell and 1 deg. Both maps must have the same cell_m. Independent of the thread count.
/// After correlative scan matching (Olson, ICRA 2009) with free space held against walls.
std::vector<WallMatch> correlate(const WallMap& a, const WallMap& b, std::size_t most, int threads);

}  // namespace headframe
