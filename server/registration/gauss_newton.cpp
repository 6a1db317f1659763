#include "server/registration/gauss_newton.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

#include "server/registration/fit_report.hpp"

namespace headframe {
namespace {

constexpr double wildest_step = 20;  // rad and m; a larger step means that the equations were nearly singular

/// Both local frames have z along gravity, so T should hardly tilt: until the last stage a spring pulls R z back to z,
/// with a stiffness relative to that of the points' rotation. The last stage is free, so its tilt shows whether the fit
/// is right.
void add_gravity(NormalEquations& sums, const Pose& T, double stiffness) {
  const Eigen::Vector3d z = T.linear().col(2);
  Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
  J.leftCols<3>() = -skew(z).topRows<2>();
  const double weight = stiffness * sums.H.topLeftCorner<3, 3>().trace() / 3;
  sums.H += weight * J.transpose() * J;
  sums.b += weight * J.transpose() * z.head<2>();
}

/// Applies an increment that rotates about `centre`, so that rotation and translation are nearly independent.
Pose apply(const Vector6d& d, const Eigen::Vector3d& centre, const Pose& T) {
  return Eigen::Translation3d(centre) * se3_exp(d) * Eigen::Translation3d(-centre) * T;
}

}  // namespace

std::string_view to_string(RegistrationStatus status) {
  static constexpr std::array<std::string_view, 4> names{"converged", "not_converged", "degenerate",
                                                         "too_little_overlap"};
  return names.at(static_cast<std::size_t>(status));
}

Registration gauss_newton(const std::vector<Stage>& stages, const Pose& T_0, const Eigen::Vector3d& mean,
                          const GaussNewtonConfig& config) {
  Registration r;
  r.T_target_source = T_0;
  if (stages.empty() || !T_0.matrix().allFinite()) return r;
  const auto enough = [&](const Stage& stage) { return std::max(10.0, config.least_inliers * stage.source_points); };
  bool settled = false;
  for (const Stage& stage : stages) {
    const bool last = &stage == &stages.back();
    settled = false;
    for (int i = 0; i < config.iterations && !settled; ++i, ++r.iterations) {
      const Eigen::Vector3d centre = r.T_target_source * mean;
      NormalEquations sums = stage.linearise(r.T_target_source, centre, nullptr);
      if (sums.inliers < enough(stage)) return r;
      if (!last) add_gravity(sums, r.T_target_source, config.gravity_stiffness);
      sums.H.diagonal() *= 1 + 1e-6;
      const Vector6d d = -sums.H.ldlt().solve(sums.b);
      if (!d.allFinite() || d.norm() > wildest_step) return r;
      r.T_target_source = apply(d, centre, r.T_target_source);
      const double fine = last ? 1 : 10;
      settled = d.head<3>().norm() < 2e-4 * fine && d.tail<3>().norm() < 1e-3 * fine;
    }
  }
  r.T_target_source = orthonormalised(r.T_target_source);
  std::vector<float> distances_m;
  const NormalEquations sums = stages.back().linearise(r.T_target_source, r.T_target_source * mean, &distances_m);
  r.centre = r.T_target_source * mean;
  report_fit(r, sums, stages.back().source_points, config.degenerate_below, std::move(distances_m));
  if (sums.inliers < enough(stages.back())) return r;
  r.status = !settled                    ? RegistrationStatus::not_converged
             : r.free_directions.empty() ? RegistrationStatus::converged
                                         : RegistrationStatus::degenerate;
  return r;
}

Eigen::Vector3d mean_point(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

}  // namespace headframe
