#include "server/registration/submap.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr float view_reach_m = 20;
constexpr std::size_t views_asked = 8;

Points place(std::span<const PlacedCloud> clouds) {
  Points points;
  for (const PlacedCloud& c : clouds) {
    const Eigen::Matrix3f R = c.T_local_sensor.linear().cast<float>();
    const Eigen::Vector3f t = c.T_local_sensor.translation().cast<float>();
    for (const auto& p : c.cloud->points) points.push_back(R * p + t);
  }
  return points;
}

/// Drops what the session's own rays see through as often as they meet it: dust is met once, by the sweep that made it.
Points without_transients(Points points, std::span<const PlacedCloud> clouds) {
  struct Placed {
    Eigen::Isometry3f T_view_local;
    Eigen::Vector3f origin;
    const RangeImage* image;
  };
  std::vector<Placed> views;
  for (const PlacedCloud& c : clouds)
    for (const auto& view : c.cloud->views) {
      const Eigen::Isometry3f T = (c.T_local_sensor * Eigen::Translation3d(view.origin.cast<double>())).cast<float>();
      views.push_back({T.inverse(), T.translation(), &view.image});
    }
  const auto transient = [&](const Eigen::Vector3f& p) {
    std::size_t asked = 0;
    int through = 0, hits = 0;
    for (const Placed& view : views) {
      if ((view.origin - p).squaredNorm() > view_reach_m * view_reach_m) continue;
      const Sight sight = view.image->look(view.T_view_local * p, view_reach_m);
      through += sight == Sight::through;
      hits += sight == Sight::hit;
      if (sight != Sight::unknown && ++asked == views_asked) break;
    }
    return through >= 1 && through >= hits;
  };
  std::erase_if(points, transient);
  return points;
}

}  // namespace

PreparedCloud prepare(const KeyframeCloud& cloud) {
  PreparedCloud out;
  Points all;
  for (const Sweep& sweep : cloud.sweeps) {
    Points seen_from_origin;
    for (const auto& p : sweep.points) {
      if (!p.allFinite()) continue;
      all.push_back(p);
      seen_from_origin.push_back(p - sweep.origin);
    }
    out.views.push_back({sweep.origin, RangeImage(seen_from_origin)});
  }
  out.points = voxel_grid(all, prepared_leaf_m);
  return out;
}

Points sphere(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double radius_m, float leaf_m) {
  constexpr double sight_m = 15;  // clouds from farther out add little to the sphere but noise
  std::vector<PlacedCloud> near;
  for (const PlacedCloud& c : clouds)
    if ((c.T_local_sensor.translation() - centre).norm() < radius_m + sight_m) near.push_back(c);
  Points points = place(near);
  const Eigen::Vector3f c = centre.cast<float>();
  const auto r2 = static_cast<float>(radius_m * radius_m);
  std::erase_if(points, [&](const Eigen::Vector3f& p) { return (p - c).squaredNorm() > r2; });
  return without_transients(voxel_grid(points, leaf_m), near);
}

Points merged(std::span<const PlacedCloud> clouds, float leaf_m) {
  return without_transients(voxel_grid(place(clouds), leaf_m), clouds);
}

double sphere_radius_m(double l) {
  if (l >= 10) return 25;
  if (l >= 6) return 15 + (l - 6) / 4 * 10;
  if (l >= 3) return 10 + (l - 3) / 3 * 5;
  return 2 * l;
}

}  // namespace headframe
