#include "server/operator/overlay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/operator/api_json.hpp"
#include "server/registration/surfels.hpp"

namespace headframe {
namespace {

constexpr double meet_m = 10;           // keyframes this near to one of the other session belong to the overlap
constexpr double around_m = 15;         // points this near to such a keyframe are used
constexpr std::size_t keyframes = 12;   // maximum per session, spread over the overlap
constexpr float surface_leaf_m = 0.1F;  // thinning before distances are measured
constexpr float bin_m = 0.02F, reach_m = 0.5F;
constexpr std::size_t bins = 25;

using Keyframes = std::vector<Keyframe>;

double distance_m(const Eigen::Vector3d& p, const Keyframes& others, const Pose& T) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Keyframe& other : others) nearest = std::min(nearest, (T * other.T_local_sensor.translation() - p).norm());
  return nearest;
}

/// The keyframes of `own` in the overlap; if there is no overlap (any more), those nearest to the other session.
Keyframes of_overlap(const Keyframes& own, const Keyframes& others, const Pose& T_own_others) {
  std::vector<double> distances;
  distances.reserve(own.size());
  for (const Keyframe& keyframe : own)
    distances.push_back(distance_m(keyframe.T_local_sensor.translation(), others, T_own_others));
  const double reach =
      distances.empty() ? meet_m : std::max(meet_m, *std::min_element(distances.begin(), distances.end()));
  Keyframes out;
  for (std::size_t i = 0; i < own.size(); ++i)
    if (distances[i] <= reach) out.push_back(own[i]);
  return out;
}

/// The stored clouds of some of the keyframes, thinned, in the target frame of T_frame_session. The frame's origin
/// should be near, because points have single precision.
Result<Points> points_around(const Station& station, SessionId session, const Keyframes& near,
                             const Pose& T_frame_session) {
  Points all;
  const std::size_t step = std::max<std::size_t>(1, (near.size() + keyframes - 1) / keyframes);
  for (std::size_t i = 0; i < near.size(); i += step) {
    const auto cloud = station.cloud(session, near[i].sequence);
    if (!cloud && cloud.error().code == ErrorCode::not_found) continue;
    if (!cloud) return tl::unexpected(cloud.error());
    const Eigen::Isometry3f T = (T_frame_session * near[i].T_local_sensor).cast<float>();
    for (const Sweep& sweep : cloud->sweeps)
      for (const Eigen::Vector3f& p_sensor : sweep.points)
        if (p_sensor.allFinite() && p_sensor.squaredNorm() < around_m * around_m) all.push_back(T * p_sensor);
  }
  return voxel_grid(all, surface_leaf_m);
}

/// Thins the points evenly to at most `most`.
Points thinned(Points points, std::size_t most) {
  for (float leaf_m = surface_leaf_m; points.size() > most && leaf_m < 100;) {
    leaf_m *= std::max(
        1.1F, std::sqrt(static_cast<float>(points.size()) / static_cast<float>(std::max<std::size_t>(1, most))));
    points = voxel_grid(points, leaf_m);
  }
  points.resize(std::min(points.size(), most));
  return points;
}

struct ResidualCounts {
  std::array<std::uint64_t, bins> counts{};
  std::uint64_t unmatched = 0;
};

ResidualCounts residuals(const Points& a, const Points& b) {
  const Surfels surface = make_surfels(a);
  ResidualCounts out;
  for (const Eigen::Vector3f& p : b) {
    Neighbour nearest;
    if (!surface.tree.nearest(p, reach_m, nearest)) {
      ++out.unmatched;
      continue;
    }
    const float off_m = std::abs(surface.normals[nearest.index].dot(p - surface.points[nearest.index]));
    ++out.counts[std::min(bins - 1, static_cast<std::size_t>(off_m / bin_m))];
  }
  return out;
}

nlohmann::json rows(const Points& points, const Eigen::Vector3d& origin_m) {
  nlohmann::json out = nlohmann::json::array();
  const auto millimetres = [](double value) { return std::round(value * 1000) / 1000; };
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3d p_a = p.cast<double>() + origin_m;
    out.push_back({millimetres(p_a.x()), millimetres(p_a.y()), millimetres(p_a.z())});
  }
  return out;
}

}  // namespace

Result<std::optional<std::string>> OverlayJson::next() {
  if (std::exchange(done_, true)) return std::nullopt;
  const auto of_a = station_.trajectory(alignment_.a), of_b = station_.trajectory(alignment_.b);
  for (const auto* path : {&of_a, &of_b})
    if (!*path) return tl::unexpected(path->error());
  const Pose& T_a_b = alignment_.T_a_b;
  const Keyframes near_a = of_overlap(*of_a, *of_b, T_a_b), near_b = of_overlap(*of_b, *of_a, T_a_b.inverse());
  // Points have single precision, and the origin of a's frame may be far away.
  const Eigen::Vector3d origin_m =
      near_a.empty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(near_a.front().T_local_sensor.translation());
  const Pose T_near_a(Eigen::Translation3d(-origin_m));
  const auto a = points_around(station_, alignment_.a, near_a, T_near_a);
  const auto b = points_around(station_, alignment_.b, near_b, T_near_a * T_a_b);
  for (const auto* points : {&a, &b})
    if (!*points) return tl::unexpected(points->error());
  if (a->empty() || b->empty())
    return failure(ErrorCode::not_found,
                   "no cloud around the overlap is stored yet; request-clouds asks the robot for them");
  const ResidualCounts off = residuals(*a, *b);
  nlohmann::json runner_up;
  if (alignment_.T_a_b_runner_up)
    runner_up = {{"T_a_b", row_major(*alignment_.T_a_b_runner_up)}, {"probability", alignment_.evidence.runner_up}};
  const nlohmann::json out{{"a", rows(thinned(*a, most_), origin_m)},
                           {"b", rows(thinned(*b, most_), origin_m)},
                           {"residuals_m", off.counts},
                           {"bin_m", std::round(bin_m * 1e6) / 1e6},
                           {"unmatched", off.unmatched},
                           {"runner_up", std::move(runner_up)}};
  return out.dump() + "\n";
}

}  // namespace headframe
