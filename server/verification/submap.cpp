#include "server/verification/submap.hpp"

#include <algorithm>
#include <numeric>

namespace headframe {
namespace {

SurfelCloud within(const SurfelCloud& all, const Eigen::Vector3d& p, double radius_m) {
  SurfelCloud out;
  const Eigen::Vector3f centre = p.cast<float>();
  const auto r2 = static_cast<float>(radius_m * radius_m);
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    if ((all.points[i] - centre).squaredNorm() > r2) continue;
    out.points.push_back(all.points[i]);
    out.normals.push_back(all.normals[i]);
  }
  return out;
}

SurfelCloud thinned(const SurfelCloud& all, std::size_t most) {
  SurfelCloud out;
  for (const std::uint32_t i : scattered(all.points.size(), most)) {
    out.points.push_back(all.points[i]);
    out.normals.push_back(all.normals[i]);
  }
  return out;
}

Recorded recorded_of(std::span<const PlacedCloud> clouds) {
  if (clouds.empty() || !std::all_of(clouds.begin(), clouds.end(), [](const auto& c) { return is_date(c.stamp_s); }))
    return {};
  const auto [first, last] = std::minmax_element(clouds.begin(), clouds.end(),
                                                 [](const auto& c, const auto& d) { return c.stamp_s < d.stamp_s; });
  return {first->stamp_s, last->stamp_s};
}

}  // namespace

std::size_t bytes_of(const Submap& submap) {
  return sizeof(Submap) + bytes_of(submap.source) + bytes_of(submap.rock) +
         submap.views.capacity() * sizeof(PlacedView) +
         std::accumulate(submap.target.begin(), submap.target.end(), std::size_t{0},
                         [](std::size_t sum, const VoxelMap& map) { return sum + map.bytes(); });
}

Submap make_submap(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p, const SubmapConfig& config) {
  const auto reach_m = static_cast<float>(config.view_reach_m);
  Submap out;
  out.p = p;
  out.recorded = recorded_of(clouds);
  const SurfelCloud all = sphere(clouds, p, config.radius_m + config.slack_m, config.leaf_m);
  out.target = make_voxel_maps(all.points, all.normals);
  out.source = thinned(within(all, p, config.radius_m), config.source_points);
  out.scatter_m = scatter_m(out.target, out.source.points, out.source.normals);
  out.views = views_near(clouds, p, config.view_reach_m);
  out.rock = without_transients(sphere(clouds, p, config.look_m, config.look_leaf_m), out.views, reach_m);
  return out;
}

}  // namespace headframe
