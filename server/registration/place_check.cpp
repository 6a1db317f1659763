#include "server/registration/place_check.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

/// Distance of p from the surface that a voxel knows, along its normals.
float plane_distance(const Voxel& v, const Eigen::Vector3f& p) {
  const Eigen::Vector3f e = p - v.mean;
  const auto& [xx, xy, xz, yy, yz, zz] = v.N;
  const float squared = xx * e.x() * e.x() + yy * e.y() * e.y() + zz * e.z() * e.z() +
                        2 * (xy * e.x() * e.y() + xz * e.x() * e.z() + yz * e.y() * e.z());
  return std::sqrt(std::max(0.0F, squared));
}

/// Share of the points that lie within 0.3 m of a surface of the map.
double share_on_surface(const VoxelMap& map, const Points& points, const Pose& T) {
  const Eigen::Isometry3f T_f = T.cast<float>();
  std::size_t on = 0;
  for (const auto& p : points) {
    const Eigen::Vector3f q = T_f * p;
    const Voxel* v = map.nearest(q);
    on += v && plane_distance(*v, q) < 0.3F;
  }
  return points.empty() ? 0 : static_cast<double>(on) / static_cast<double>(points.size());
}

/// Both submaps summed up by cubes, so that a lidar's noise averages out and what is left is the shape of the rock: how
/// far apart the sums lie along the normals, median.
double median_residual_m(const VoxelMap& a, const VoxelMap& b, const Pose& T) {
  constexpr float least_surfels = 3;
  const Eigen::Isometry3f T_f = T.cast<float>();
  std::vector<float> distances;
  for (const Voxel& voxel : b.voxels()) {
    if (voxel.count < least_surfels) continue;
    const Eigen::Vector3f p = T_f * voxel.mean;
    const Voxel* partner = a.nearest(p);
    if (partner && partner->count >= least_surfels) distances.push_back(plane_distance(*partner, p));
  }
  if (distances.empty()) return 1;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return static_cast<double>(*middle);
}

/// A session's rock around a place, and the sweeps it was seen from.
struct Surroundings {
  Submap rock;
  std::vector<PlacedView> views;
};

Surroundings surroundings(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p, const PlaceConfig& config) {
  Surroundings out{{}, views_near(clouds, p, config.view_reach_m)};
  out.rock = without_transients(sphere(clouds, p, config.look_m, config.look_leaf_m), out.views,
                                static_cast<float>(config.view_reach_m));
  return out;
}

/// A session against itself: every other sweep on the points that the ones between kept.
Visibility own_visibility(const Surroundings& self, std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p,
                          const PlaceConfig& config) {
  std::vector<PlacedCloud> odd;
  for (std::size_t i = 1; i < clouds.size(); i += 2) odd.push_back(clouds[i]);
  return look_from(views_near(odd, p, config.view_reach_m), self.rock, Pose::Identity(),
                   static_cast<float>(config.view_reach_m), config.look_leaf_m);
}

}  // namespace

PlaceCheck register_place(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Eigen::Vector3d& p_b,
                          const Pose& T_a_b, const PlaceConfig& config) {
  PlaceCheck out;
  out.p_b = p_b;
  const Submap target = sphere(a, T_a_b * p_b, config.radius_m + config.slack_m, config.leaf_m);
  const Submap source = sphere(b, p_b, config.radius_m, config.leaf_m);
  const VoxelMaps maps = make_voxel_maps(target.points, target.normals);
  out.registration = align(maps, source.points, source.normals, T_a_b);
  const Pose& T = out.registration.T_target_source;
  out.p_a = T * p_b;
  if (out.registration.status == RegistrationStatus::too_little_overlap) return out;
  out.residual_m = median_residual_m(maps.back(), VoxelMap(source.points, source.normals, maps.back().leaf_m()), T);
  const double here = share_on_surface(maps.back(), source.points, T);
  double slid = 0;
  for (const double way : {-1.0, -0.5, 0.5, 1.0})
    slid = std::max(
        slid, share_on_surface(maps.back(), source.points,
                               Eigen::Translation3d(way * config.slide_m * out.registration.weakest_direction) * T));
  out.slide_ratio = here > 0 ? slid / here : 1;
  return out;
}

void look_at_place(PlaceCheck& place, std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_a_b,
                   const PlaceConfig& config) {
  const Eigen::Vector3d p_a = T_a_b * place.p_b;
  const auto reach = static_cast<float>(config.view_reach_m);
  const Surroundings of_a = surroundings(a, p_a, config), of_b = surroundings(b, place.p_b, config);
  place.between = look_from(of_a.views, of_b.rock, T_a_b, reach, config.look_leaf_m);
  place.between += look_from(of_b.views, of_a.rock, T_a_b.inverse(), reach, config.look_leaf_m);
  place.own = own_visibility(of_a, a, p_a, config);
  place.own += own_visibility(of_b, b, place.p_b, config);
}

}  // namespace headframe
