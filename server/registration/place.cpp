#include "server/registration/place.hpp"

#include <numeric>

namespace headframe {
namespace {

Submap within(const Submap& all, const Eigen::Vector3d& p, double radius_m) {
  Submap out;
  const Eigen::Vector3f centre = p.cast<float>();
  const auto r2 = static_cast<float>(radius_m * radius_m);
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    if ((all.points[i] - centre).squaredNorm() > r2) continue;
    out.points.push_back(all.points[i]);
    out.normals.push_back(all.normals[i]);
  }
  return out;
}

Submap thinned(const Submap& all, std::size_t most) {
  Submap out;
  for (const std::uint32_t i : scattered(all.points.size(), most)) {
    out.points.push_back(all.points[i]);
    out.normals.push_back(all.normals[i]);
  }
  return out;
}

}  // namespace

std::size_t bytes_of(const Place& place) {
  return sizeof(Place) + bytes_of(place.source) + bytes_of(place.rock) + place.views.capacity() * sizeof(PlacedView) +
         std::accumulate(place.target.begin(), place.target.end(), std::size_t{0},
                         [](std::size_t sum, const VoxelMap& map) { return sum + map.bytes(); });
}

Place make_place(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p, const PlaceConfig& config) {
  const auto reach_m = static_cast<float>(config.view_reach_m);
  Place out;
  out.p = p;
  const Submap all = sphere(clouds, p, config.radius_m + config.slack_m, config.leaf_m);
  out.target = make_voxel_maps(all.points, all.normals);
  out.source = thinned(within(all, p, config.radius_m), config.source_points);
  out.views = views_near(clouds, p, config.view_reach_m);
  out.rock = without_transients(sphere(clouds, p, config.look_m, config.look_leaf_m), out.views, reach_m);
  std::vector<PlacedCloud> odd;
  for (std::size_t i = 1; i < clouds.size(); i += 2) odd.push_back(clouds[i]);
  out.own = look_from(views_near(odd, p, config.view_reach_m), out.rock, Pose::Identity(), reach_m, config.look_leaf_m);
  return out;
}

}  // namespace headframe
