#include "tests/bench/registration/gicp.hpp"

#include <cmath>

#include "server/registration/gauss_newton.hpp"

namespace headframe {
namespace {

/// `partners`: of every source point, the partner of the last pass: the search starts from there, and finds the same.
NormalEquations linearise(const Surfels& target, const Surfels& source, const Pose& T, const Eigen::Vector3d& centre,
                          double reach_m, const GicpConfig& config, std::vector<std::uint32_t>& partners,
                          std::vector<float>* distances_m) {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>(), c = centre.cast<float>();
  const auto squared_reach = static_cast<float>(reach_m * reach_m);
  const auto add = [&](std::size_t begin, std::size_t end, FactorBlock& factors) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3f p = R * source.points[i] + t;
      Neighbour partner{KdTree::nobody, squared_reach};
      if (partners[i] != KdTree::nobody) {
        const float squared_m = (target.points[partners[i]] - p).squaredNorm();
        if (squared_m < squared_reach) partner = {partners[i], squared_m};
      }
      target.tree.improve(p, partner);
      partners[i] = partner.index;
      if (partner.index == KdTree::nobody) continue;
      factors.add(p - c, p - target.points[partner.index], outer(target.normals[partner.index]), R * source.normals[i]);
    }
  };
  return sum_factors(source.size(), config.threads, config.factor, reach_m, add, distances_m);
}

}  // namespace

Registration align(const Surfels& target, const Surfels& source, const Pose& T_0, const GicpConfig& config) {
  std::vector<std::uint32_t> partners(source.size(), KdTree::nobody);
  std::vector<Stage> stages;
  stages.reserve(static_cast<std::size_t>(std::max(0, config.stages)));
  for (int i = 0; i < config.stages; ++i) {
    const double share = config.stages > 1 ? static_cast<double>(i) / (config.stages - 1) : 1;
    const double reach = config.coarse_reach_m * std::pow(config.fine_reach_m / config.coarse_reach_m, share);
    stages.push_back({[&, reach](const Pose& T, const Eigen::Vector3d& centre, std::vector<float>* distances_m) {
                        return linearise(target, source, T, centre, reach, config, partners, distances_m);
                      },
                      static_cast<double>(source.size())});
  }
  return gauss_newton(stages, T_0, mean_point(source.points),
                      {config.iterations, config.least_inliers, config.degenerate_below, config.gravity_stiffness});
}

}  // namespace headframe
