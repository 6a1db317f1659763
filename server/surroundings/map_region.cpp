#include "server/surroundings/map_region.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <unordered_map>

namespace headframe {
namespace {

/// Sum of the points in a cube, to be divided by their number.
struct Cube {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  std::size_t points = 0;
};

/// 21 bits for each axis: regions are at most 400 m wide, with cubes of at least 0.05 m.
std::uint64_t cube_of(const Eigen::Vector3d& p_m, double edge_m) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis)
    key = key << 21 | (static_cast<std::uint64_t>(std::llround(std::floor(p_m[axis] / edge_m)) + (1 << 20)) & 0x1fffff);
  return key;
}

template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

std::string objection(const SphereRegion& sphere, const MapLimits& limits) {
  if (!sphere.centre_m.allFinite() || !(sphere.radius_m > 0)) return "a sphere needs a centre and a radius above 0 m";
  if (sphere.radius_m <= limits.radius_m) return "";
  return text("a radius of ", sphere.radius_m, " m is more than ", limits.radius_m, " m; ask for less at a time");
}

std::string objection(const BoxRegion& box, const MapLimits& limits) {
  const Eigen::Vector3d size_m = box.high_m - box.low_m;
  if (!size_m.allFinite() || !(size_m.minCoeff() > 0))
    return "a box needs a low corner below its high one on each axis";
  if (size_m.maxCoeff() <= 2 * limits.radius_m) return "";
  return text("a box of ", size_m.maxCoeff(), " m is longer than ", 2 * limits.radius_m, " m; ask for less at a time");
}

}  // namespace

std::string objection(const Region& region, double resolution_m, const MapLimits& limits) {
  if (!(resolution_m >= limits.least_resolution_m && resolution_m <= limits.most_resolution_m))
    return text("a resolution of ", resolution_m, " m is not within ", limits.least_resolution_m, " to ",
                limits.most_resolution_m, " m");
  return std::visit([&](const auto& shape) { return objection(shape, limits); }, region);
}

Eigen::Vector3d middle_m(const Region& region) {
  if (const auto* sphere = std::get_if<SphereRegion>(&region)) return sphere->centre_m;
  const auto& box = std::get<BoxRegion>(region);
  return (box.low_m + box.high_m) / 2;
}

double distance_m(const Region& region, const Eigen::Vector3d& p_m) {
  if (const auto* sphere = std::get_if<SphereRegion>(&region))
    return std::max(0.0, (p_m - sphere->centre_m).norm() - sphere->radius_m);
  const auto& box = std::get<BoxRegion>(region);
  return (p_m - p_m.cwiseMax(box.low_m).cwiseMin(box.high_m)).norm();
}

std::vector<RegionCloud> clouds_near(std::vector<RegionCloud> all, const Region& region, const MapLimits& limits,
                                     std::size_t& left_out) {
  std::erase_if(
      all, [&](const RegionCloud& c) { return distance_m(region, c.T_region_sensor.translation()) > limits.reach_m; });
  std::sort(all.begin(), all.end(), [](const RegionCloud& a, const RegionCloud& b) {
    return a.stamp_s != b.stamp_s ? a.stamp_s > b.stamp_s : a.keyframe < b.keyframe;
  });
  left_out = all.size() - std::min(all.size(), limits.clouds);
  all.resize(all.size() - left_out);
  return all;
}

Result<FusedPoints> fuse(const std::vector<RegionCloud>& clouds, const Region& region, double resolution_m,
                         const MapLimits& limits, const std::function<Result<KeyframeCloud>(const KeyframeRef&)>& read,
                         const std::function<bool()>& stop) {
  FusedPoints fused;
  const Eigen::Vector3d middle = middle_m(region);
  std::unordered_map<std::uint64_t, std::size_t> place;  // of a cube
  std::vector<Cube> cubes;                               // in the order in which they were filled
  for (const RegionCloud& from : clouds) {
    if (stop()) return failure(ErrorCode::unavailable, "the server stops");
    const auto cloud = read(from.keyframe);
    if (!cloud) continue;
    ++fused.clouds;
    for (const Sweep& sweep : cloud->sweeps)
      for (const Eigen::Vector3f& p_sensor : sweep.points) {
        const Eigen::Vector3d p_m = from.T_region_sensor * p_sensor.cast<double>();
        if (!p_m.allFinite() || distance_m(region, p_m) > 0) continue;
        const auto [at, fresh] = place.try_emplace(cube_of(p_m - middle, resolution_m), cubes.size());
        if (fresh) cubes.emplace_back();
        if (cubes.size() > limits.points)
          return failure(ErrorCode::invalid_argument, text("more than ", limits.points, " points at ", resolution_m,
                                                           " m; ask for a smaller region or a coarser resolution"));
        cubes[at->second].sum_m += p_m - middle;
        ++cubes[at->second].points;
      }
  }
  for (const Cube& cube : cubes)
    fused.points.emplace_back((cube.sum_m / static_cast<double>(cube.points)).cast<float>());
  return fused;
}

}  // namespace headframe
