#include "server/verification/meeting.hpp"

#include <algorithm>
#include <limits>

namespace headframe {
namespace {

/// Path, in metres, along which these follow each other in their session. Between keyframes farther apart than any
/// selection puts them the robot drove back over its own path.
double shared_path_m(const std::vector<KeyframePosition>& near) {
  constexpr double farthest_m = 15;
  double path = 0;
  for (std::size_t i = 1; i < near.size(); ++i)
    if (const double step_m = (near[i].p - near[i - 1].p).norm();
        near[i].keyframe - near[i - 1].keyframe <= 2 && step_m < farthest_m)
      path += step_m;
  return path;
}

}  // namespace

NearestPosition nearest_to(std::span<const KeyframePosition> positions, const Eigen::Vector3d& p) {
  NearestPosition out;
  for (const KeyframePosition& s : positions)
    if (const double d = (s.p - p).norm(); d < out.distance_m) out = {&s, d};
  return out;
}

std::vector<KeyframePosition> near_other(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                         const Pose& T_a_b, double reach_m) {
  std::vector<KeyframePosition> out;
  for (const KeyframePosition& s : b)
    if (nearest_to(a, T_a_b * s.p).distance_m < reach_m) out.push_back(s);
  return out;
}

void measure_overlap(Evidence& e, std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                     const Pose& T_a_b, const JudgeConfig& config) {
  // One may pass where the other stopped: the mean of both.
  std::vector<KeyframePosition> of_a, of_b;
  for (const double reach_m : {config.meet_m, config.far_m}) {
    if (!of_a.empty() && !of_b.empty()) break;
    of_a = near_other(b, a, T_a_b.inverse(), reach_m);
    of_b = near_other(a, b, T_a_b, reach_m);
  }
  e.pairs = static_cast<double>(of_a.size() + of_b.size()) / 2;
  e.overlap_m = (shared_path_m(of_a) + shared_path_m(of_b)) / 2;
}

std::optional<Meeting> first_meeting(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                     const Pose& T_0, const Eigen::Vector3d& p_b, const JudgeConfig& config) {
  std::optional<Meeting> out;
  double least = std::numeric_limits<double>::max(), nearest_m = config.apart_m;
  for (const KeyframePosition& s : b) {
    const NearestPosition other = nearest_to(a, T_0 * s.p);
    const double cost = (s.p - p_b).norm() + 10 * std::max(0.0, other.distance_m - config.meet_m / 2);
    nearest_m = std::min(nearest_m, other.distance_m);
    if (cost >= least || other.distance_m > config.apart_m) continue;
    least = cost;
    out = {other.position->keyframe, s.keyframe};
  }
  if (!out || nearest_m <= config.meet_m) return out;
  // Where the paths come nearest to each other there may be rock between them: each looks from where it is nearest to
  // what both saw.
  const NearestPosition of_a = nearest_to(a, T_0 * p_b), of_b = nearest_to(b, p_b);
  if (std::max(of_a.distance_m, of_b.distance_m) > config.far_m) return out;
  return Meeting{of_a.position->keyframe, of_b.position->keyframe};
}

}  // namespace headframe
