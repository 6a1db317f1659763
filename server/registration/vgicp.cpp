#include "server/registration/vgicp.hpp"

#include <algorithm>

#include "server/registration/gauss_newton.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

/// Which of `count` points to take so that at most `most` remain: scattered like a Weyl sequence, so that it does not
/// fall in step with the rings of a lidar.
std::vector<std::uint32_t> scattered(std::size_t count, std::size_t most) {
  std::vector<std::uint32_t> out;
  out.reserve(std::min(count, most));
  const double share = static_cast<double>(most) / static_cast<double>(std::max<std::size_t>(1, count));
  const auto below = static_cast<std::uint64_t>(std::min(1.0, share) * 4294967296.0);
  for (std::size_t i = 0; i < count && out.size() < most; ++i)
    if ((i * 2654435769ULL & 0xFFFFFFFFULL) < below) out.push_back(static_cast<std::uint32_t>(i));
  return out;
}

struct Source {
  const Points& points;
  const Points& normals;
  std::vector<std::uint32_t> taken;
};

NormalEquations linearise(const VoxelMap& target, const Source& source, const Pose& T, const Eigen::Vector3d& centre,
                          const VgicpConfig& config, std::vector<float>* distances_m) {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>(), c = centre.cast<float>();
  constexpr std::size_t size = FactorBlock::capacity;
  std::vector<NormalEquations> sums((source.taken.size() + size - 1) / size);
  std::vector<std::vector<float>> distances(distances_m ? sums.size() : 0);
  for_blocks(source.taken.size(), size, config.threads, [&](std::size_t begin, std::size_t end, std::size_t block) {
    FactorBlock factors;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = source.taken[k];
      const Eigen::Vector3f p = R * source.points[i] + t;
      if (const Voxel* v = target.nearest(p)) factors.add(p - c, p - v->mean, v->N, R * source.normals[i]);
    }
    sums[block] = factors.sum(config.factor, target.leaf_m());
    if (distances_m) factors.append_distances(distances[block]);
  });
  NormalEquations total;
  for (const NormalEquations& s : sums) total += s;
  if (!distances_m) return total;
  for (const auto& d : distances) distances_m->insert(distances_m->end(), d.begin(), d.end());
  return total;
}

}  // namespace

VoxelMaps make_voxel_maps(const Points& points, const Points& normals, const VgicpConfig& config) {
  VoxelMaps maps;
  maps.reserve(config.levels.size());
  for (const VgicpLevel& level : config.levels) maps.emplace_back(points, normals, level.leaf_m);
  return maps;
}

Registration align(const VoxelMaps& target, const Points& source, const Points& source_normals, const Pose& T_0,
                   const VgicpConfig& config) {
  std::vector<Stage> stages;
  stages.reserve(config.levels.size());
  for (const VgicpLevel& level : config.levels) {
    const auto same_leaf = [&](const VoxelMap& map) { return map.leaf_m() == level.leaf_m; };
    const auto map = std::find_if(target.begin(), target.end(), same_leaf);
    if (map == target.end()) continue;
    Source taken{source, source_normals, scattered(source.size(), level.source_points)};
    const auto count = static_cast<double>(taken.taken.size());
    stages.push_back({[&map = *map, taken = std::move(taken), &config](const Pose& T, const Eigen::Vector3d& centre,
                                                                       std::vector<float>* distances_m) {
                        return linearise(map, taken, T, centre, config, distances_m);
                      },
                      count});
  }
  return gauss_newton(stages, T_0, mean_point(source),
                      {config.iterations, config.least_inliers, config.degenerate_below, config.gravity_stiffness});
}

}  // namespace headframe
