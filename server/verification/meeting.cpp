#include "server/verification/meeting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headframe {
namespace {

/// A straight piece of a path: from one keyframe to the next.
struct Piece {
  Eigen::Vector3d from, to;
  Eigen::Vector3d middle() const { return (from + to) / 2; }
  double length_m() const { return (to - from).norm(); }
};

/// If keyframes are farther apart than any selection puts them, nothing is known of the path between them.
std::vector<Piece> pieces(std::span<const KeyframePosition> path, const Pose& T) {
  constexpr double farthest_m = 15;
  std::vector<Piece> out;
  for (std::size_t i = 1; i < path.size(); ++i)
    if (path[i].keyframe - path[i - 1].keyframe <= 2 && (path[i].p - path[i - 1].p).norm() < farthest_m)
      out.push_back({T * path[i - 1].p, T * path[i].p});
  return out;
}

double distance_m(const Piece& piece, const Eigen::Vector3d& p) {
  const Eigen::Vector3d along = piece.to - piece.from;
  const double at = along.dot(p - piece.from) / std::max(along.squaredNorm(), 1e-12);
  return (piece.from + std::clamp(at, 0.0, 1.0) * along - p).norm();
}

/// Metres of this piece along which the other path passes, sampled at each metre.
double shared_m(const Piece& piece, const std::vector<Piece>& others, const JudgeConfig& config) {
  const int steps = static_cast<int>(std::ceil(piece.length_m()));
  double out = 0;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d p = piece.from + (i + 0.5) / steps * (piece.to - piece.from);
    double nearest_m = config.parted_m;
    for (const Piece& other : others) nearest_m = std::min(nearest_m, distance_m(other, p));
    out += std::min(1.0, (config.parted_m - nearest_m) / (config.parted_m - config.shared_m));
  }
  return out * piece.length_m() / std::max(1, steps);
}

/// Metres of a path along which the other path passes.
double shared_path_m(std::span<const Piece> path, std::span<const Piece> other, const JudgeConfig& config) {
  double out = 0;
  for (const Piece& piece : path) {
    std::vector<Piece> near;
    for (const Piece& o : other)
      if ((o.middle() - piece.middle()).norm() < config.parted_m + (o.length_m() + piece.length_m()) / 2)
        near.push_back(o);
    out += shared_m(piece, near, config);
  }
  return out;
}

/// Adds candidates as far from each other as possible, none nearer than 4 m to another or to the first place, which is
/// already taken.
void spread(const Eigen::Vector3d& first, const std::vector<KeyframePosition>& candidates, std::size_t most,
            std::vector<KeyframePosition>& chosen) {
  constexpr double same_place_m = 4;
  while (chosen.size() < most) {
    double farthest = same_place_m;
    const KeyframePosition* next = nullptr;
    for (const KeyframePosition& s : candidates) {
      double nearest = (s.p - first).norm();
      for (const KeyframePosition& other : chosen) nearest = std::min(nearest, (s.p - other.p).norm());
      if (nearest <= farthest) continue;
      farthest = nearest;
      next = &s;
    }
    if (!next) break;
    chosen.push_back(*next);
  }
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

Overlapping overlapping(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b, const Pose& T_a_b,
                        const JudgeConfig& config) {
  Overlapping out;
  for (const double reach_m : {config.meet_m, config.far_m}) {
    if (!out.a.empty() && !out.b.empty()) break;
    out = {near_other(b, a, T_a_b.inverse(), reach_m), near_other(a, b, T_a_b, reach_m)};
  }
  return out;
}

void measure_overlap(Evidence& e, std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                     const Pose& T_a_b, const JudgeConfig& config) {
  // One robot may have passed where the other stopped, so the mean of both is used.
  const Overlapping near = overlapping(a, b, T_a_b, config);
  e.pairs = static_cast<double>(near.a.size() + near.b.size()) / 2;
  const std::vector<Piece> path_a = pieces(a, Pose::Identity()), path_b = pieces(b, T_a_b);
  e.overlap_m = (shared_path_m(path_a, path_b, config) + shared_path_m(path_b, path_a, config)) / 2;
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
  // Where the paths come nearest to each other there may be rock between them, so each session is judged from where it
  // was nearest to what both saw.
  const NearestPosition of_a = nearest_to(a, T_0 * p_b), of_b = nearest_to(b, p_b);
  if (std::max(of_a.distance_m, of_b.distance_m) > config.far_m) return out;
  return Meeting{of_a.position->keyframe, of_b.position->keyframe};
}

std::vector<KeyframePosition> other_places(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                           const Pose& T_a_b, const Eigen::Vector3d& p_b, const JudgeConfig& config) {
  std::vector<KeyframePosition> chosen;
  for (const double reach_m : {config.close_m, config.meet_m, config.far_m})
    spread(p_b, near_other(a, b, T_a_b, reach_m), config.places - 1, chosen);
  return chosen;
}

std::vector<KeyframePosition> further_places(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                             const Pose& T_a_b, const Eigen::Vector3d& p_b, const JudgeConfig& config) {
  std::vector<KeyframePosition> places = other_places(a, b, T_a_b, p_b, config);
  if (places.size() > config.further_places) places.resize(config.further_places);
  return places;
}

}  // namespace headframe
