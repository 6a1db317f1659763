#include "server/registration/vgicp.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/registration/gauss_newton.hpp"

namespace headframe {
namespace {

/// What one level makes of a pair.
struct Source {
  const VoxelMap& target;
  const Points& points;
  const Points& normals;
  std::vector<std::uint32_t> taken;
};

NormalEquations linearise(const Source& source, const Pose& T, const Eigen::Vector3d& centre, const VgicpConfig& config,
                          std::vector<float>* distances_m) {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>(), c = centre.cast<float>();
  const auto add = [&](std::size_t begin, std::size_t end, FactorBlock& factors) {
    std::array<Eigen::Vector3f, FactorBlock::capacity> points;
    std::array<const Voxel*, FactorBlock::capacity> partners;
    const std::span<const std::uint32_t> taken(&source.taken[begin], end - begin);
    for (std::size_t k = 0; k < taken.size(); ++k) points[k] = R * source.points[taken[k]] + t;
    source.target.nearest(std::span(points).first(taken.size()), partners);
    for (std::size_t k = 0; k < taken.size(); ++k)
      if (const Voxel* v = partners[k])
        factors.add(points[k] - c, points[k] - v->mean, v->N, R * source.normals[taken[k]]);
  };
  return sum_factors(source.taken.size(), config.threads, config.factor, source.target.leaf_m(), add, distances_m);
}

}  // namespace

VoxelMaps make_voxel_maps(const Points& points, const Points& normals, const VgicpConfig& config) {
  VoxelMaps maps;
  maps.reserve(config.levels.size());
  for (const VgicpLevel& level : config.levels) maps.emplace_back(points, normals, level.leaf_m);
  return maps;
}

std::vector<std::uint32_t> scattered(std::size_t count, std::size_t most) {
  std::vector<std::uint32_t> out;
  out.reserve(std::min(count, most));
  const double share = static_cast<double>(most) / static_cast<double>(std::max<std::size_t>(1, count));
  const auto below = static_cast<std::uint64_t>(std::min(1.0, share) * 4294967296.0);
  for (std::size_t i = 0; i < count && out.size() < most; ++i)
    if ((i * 2654435769ULL & 0xFFFFFFFFULL) < below) out.push_back(static_cast<std::uint32_t>(i));
  return out;
}

Registration align(std::span<const VgicpPair> pairs, const Pose& T_0, const VgicpConfig& config) {
  std::vector<Stage> stages;
  stages.reserve(config.levels.size());
  for (const VgicpLevel& level : config.levels) {
    std::vector<Source> sources;
    double count = 0;
    for (const VgicpPair& pair : pairs) {
      const auto same_leaf = [&](const VoxelMap& map) { return map.leaf_m() == level.leaf_m; };
      const auto map = std::find_if(pair.target->begin(), pair.target->end(), same_leaf);
      if (map == pair.target->end()) continue;
      sources.push_back(
          {*map, *pair.source, *pair.normals, scattered(pair.source->size(), level.source_points / pairs.size())});
      count += static_cast<double>(sources.back().taken.size());
    }
    if (sources.empty()) continue;
    stages.push_back({[sources = std::move(sources), &config](const Pose& T, const Eigen::Vector3d& centre,
                                                              std::vector<float>* distances_m) {
                        NormalEquations total;
                        for (const Source& source : sources) total += linearise(source, T, centre, config, distances_m);
                        return total;
                      },
                      count});
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const VgicpPair& pair : pairs) mean += mean_point(*pair.source) / static_cast<double>(pairs.size());
  return gauss_newton(stages, T_0, mean,
                      {config.iterations, config.least_inliers, config.degenerate_below, config.gravity_stiffness});
}

Registration align(const VoxelMaps& target, const Points& source, const Points& source_normals, const Pose& T_0,
                   const VgicpConfig& config) {
  const VgicpPair pair{&target, &source, &source_normals};
  return align(std::span(&pair, 1), T_0, config);
}

double scatter_m(const VoxelMaps& target, const Points& points, const Points& normals, const VgicpConfig& config) {
  const Source source{target.back(), points, normals, scattered(points.size(), config.levels.back().source_points)};
  const NormalEquations sums = linearise(source, Pose::Identity(), mean_point(points), config, nullptr);
  return std::sqrt(sums.squared_plane_m2 / std::max(1.0, sums.inliers));
}

}  // namespace headframe
