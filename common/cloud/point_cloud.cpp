#include "common/cloud/point_cloud.hpp"

#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace headframe {
namespace {

struct Cube {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0;
};

/// Visits the cubes of all points in the order of their first point. `put` gets each point and the index of its cube.
template <class Put>
std::vector<Cube> cubes_of(const Points& points, float leaf_m, const Put& put) {
  constexpr float reach = 1e6F;  // cubes each way; 21 bits a coordinate
  std::unordered_map<std::uint64_t, std::size_t> index;
  index.reserve(points.size());
  std::vector<Cube> cubes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f c = (points[i] / leaf_m).array().floor();
    if (!(c.cwiseAbs().maxCoeff() < reach)) continue;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key = key << 21 | static_cast<std::uint64_t>(static_cast<std::int64_t>(c[axis]) + (1 << 20));
    const auto [it, fresh] = index.try_emplace(key, cubes.size());
    if (fresh) cubes.emplace_back();
    Cube& cube = cubes[it->second];
    cube.sum += points[i];
    cube.count += 1;
    put(i, it->second);
  }
  return cubes;
}

Points means_of(const std::vector<Cube>& cubes) {
  Points out;
  out.reserve(cubes.size());
  for (const Cube& cube : cubes) out.push_back(cube.sum / cube.count);
  return out;
}

bool is_return(const Eigen::Vector3f& p, float min_range_m) {
  return p.allFinite() && p.squaredNorm() >= min_range_m * min_range_m;
}

}  // namespace

std::size_t point_count(const KeyframeCloud& cloud) {
  std::size_t n = 0;
  for (const Sweep& sweep : cloud.sweeps) n += sweep.points.size();
  return n;
}

Points finite_points(const Points& points, float min_range_m) {
  Points out;
  out.reserve(points.size());
  for (const auto& p : points)
    if (is_return(p, min_range_m)) out.push_back(p);
  return out;
}

Returns finite_points(const Points& points, const Intensities& intensity, float min_range_m) {
  if (intensity.empty()) return {finite_points(points, min_range_m)};
  Returns out;
  out.points.reserve(points.size());
  out.intensity.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_return(points[i], min_range_m)) continue;
    out.points.push_back(points[i]);
    out.intensity.push_back(intensity[i]);
  }
  return out;
}

Points voxel_grid(const Points& points, float leaf_m) {
  return means_of(cubes_of(points, leaf_m, [](std::size_t, std::size_t) {}));
}

Returns voxel_grid(const Points& points, const Intensities& intensity, float leaf_m) {
  if (intensity.empty()) return {voxel_grid(points, leaf_m)};
  std::vector<float> sums;
  const auto cubes = cubes_of(points, leaf_m, [&](std::size_t point, std::size_t cube) {
    if (cube == sums.size()) sums.push_back(0);
    sums[cube] += static_cast<float>(intensity[point]);
  });
  Returns out{means_of(cubes)};
  out.intensity.reserve(cubes.size());
  for (std::size_t i = 0; i < cubes.size(); ++i)
    out.intensity.push_back(static_cast<std::uint8_t>(std::lround(sums[i] / cubes[i].count)));
  return out;
}

}  // namespace headframe
