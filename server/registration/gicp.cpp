#include "server/registration/gicp.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
constexpr double plane_epsilon = 1e-3;    // variance along the normal over the variance along the plane
constexpr float least_normal_dot = 0.5F;  // 60 deg
constexpr std::size_t block_points = 256;

/// What one pass over the source points gives: the normal equations and the figures of the fit.
struct Sums {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double inliers = 0;
  double squared_plane_m2 = 0;
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  void add(const Sums& o) {
    H += o.H;
    b += o.b;
    inliers += o.inliers;
    squared_plane_m2 += o.squared_plane_m2;
    normals += o.normals;
  }
};

/// One factor: e = T p_s - p_t, cost e^T (C_t + R C_s R^T)^-1 e, weighted.
void add_factor(Sums& sums, const Eigen::Vector3d& p, const Eigen::Vector3d& p_t, const Eigen::Vector3d& n_t,
                const Eigen::Vector3d& n_s, const Eigen::Vector3d& centre, double kernel) {
  const Eigen::Matrix3d C =
      2 * Eigen::Matrix3d::Identity() - (1 - plane_epsilon) * (n_t * n_t.transpose() + n_s * n_s.transpose());
  const Eigen::Matrix3d M = C.inverse();
  const Eigen::Vector3d e = p - p_t;
  const Eigen::Vector3d Me = M * e;
  const double ratio = kernel / (kernel + e.dot(Me));
  const double weight = ratio * ratio;
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() = -skew(p - centre);
  J.rightCols<3>().setIdentity();
  sums.H.noalias() += weight * J.transpose() * M * J;
  sums.b.noalias() += weight * J.transpose() * Me;
  sums.inliers += 1;
  const double along = e.dot(n_t);
  sums.squared_plane_m2 += along * along;
  sums.normals.noalias() += n_t * n_t.transpose();
}

Sums linearise(const Surfels& target, const Surfels& source, const Pose& T, const Eigen::Vector3d& centre,
               double reach_m, int threads) {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  // A plane distance of a fifth of the reach halves the square root of the weight: far partners guide, near ones
  // decide.
  const double kernel = std::pow(0.2 * reach_m, 2) / (2 * plane_epsilon);
  std::vector<Sums> sums((source.size() + block_points - 1) / block_points);
  for_blocks(source.size(), block_points, threads, [&](std::size_t begin, std::size_t end, std::size_t block) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3f p = R * source.points[i] + t;
      Neighbour partner;
      if (!target.tree.nearest(p, static_cast<float>(reach_m), partner)) continue;
      const Eigen::Vector3f n_s = R * source.normals[i];
      const Eigen::Vector3f& n_t = target.normals[partner.index];
      if (std::abs(n_s.dot(n_t)) < least_normal_dot) continue;
      add_factor(sums[block], p.cast<double>(), target.points[partner.index].cast<double>(), n_t.cast<double>(),
                 n_s.cast<double>(), centre, kernel);
    }
  });
  Sums total;
  for (const Sums& s : sums) total.add(s);
  return total;
}

/// Both local frames have z along gravity, so T may hardly tilt: until the last stage a spring pulls R z back to z, as
/// stiff as a part of what the points say of rotation. The last stage is free, and tells by its tilt whether the fit is
/// honest.
void add_gravity(Sums& sums, const Pose& T, double stiffness) {
  const Eigen::Vector3d z = T.linear().col(2);
  Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
  J.leftCols<3>() = -skew(z).topRows<2>();
  const double weight = stiffness * sums.H.topLeftCorner<3, 3>().trace() / 3;
  sums.H += weight * J.transpose() * J;
  sums.b += weight * J.transpose() * z.head<2>();
}

Eigen::Vector3d mean_point(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : points) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

/// The increment turns about `centre`, so that rotation and translation hardly mix.
Pose apply(const Vector6d& d, const Eigen::Vector3d& centre, const Pose& T) {
  return Eigen::Translation3d(centre) * se3_exp(d) * Eigen::Translation3d(-centre) * T;
}

void describe(Registration& r, const Sums& sums, std::size_t source_points) {
  r.information = sums.H;
  r.inlier_fraction = sums.inliers / static_cast<double>(source_points);
  r.rmse_m = std::sqrt(sums.squared_plane_m2 / std::max(1.0, sums.inliers));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sums.normals / std::max(1.0, sums.inliers));
  r.direction_hold = eigen.eigenvalues();
  r.weakest_direction = eigen.eigenvectors().col(0);
}

}  // namespace

std::string_view to_string(RegistrationStatus status) {
  static constexpr std::array<std::string_view, 4> names{"converged", "not_converged", "degenerate",
                                                         "too_little_overlap"};
  return names.at(static_cast<std::size_t>(status));
}

Registration align(const Surfels& target, const Surfels& source, const Pose& T_0, const GicpConfig& config) {
  Registration r;
  r.T_target_source = T_0;
  if (target.size() == 0 || source.size() == 0 || !T_0.matrix().allFinite()) return r;
  const Eigen::Vector3d mean = mean_point(source.points);
  const double enough = std::max(10.0, config.least_inliers * static_cast<double>(source.size()));
  bool settled = false;
  for (int stage = 0; stage < config.stages; ++stage) {
    const double share = config.stages > 1 ? static_cast<double>(stage) / (config.stages - 1) : 1;
    const double reach = config.coarse_reach_m * std::pow(config.fine_reach_m / config.coarse_reach_m, share);
    const bool last = stage + 1 == config.stages;
    settled = false;
    for (int i = 0; i < config.iterations && !settled; ++i, ++r.iterations) {
      const Eigen::Vector3d centre = r.T_target_source * mean;
      Sums sums = linearise(target, source, r.T_target_source, centre, reach, config.threads);
      if (sums.inliers < enough) return r;
      if (!last) add_gravity(sums, r.T_target_source, config.gravity_stiffness);
      Matrix6d H = sums.H;
      H.diagonal() *= 1 + 1e-6;
      const Vector6d d = -H.ldlt().solve(sums.b);
      if (!d.allFinite() || d.norm() > 20) return r;
      r.T_target_source = apply(d, centre, r.T_target_source);
      const double fine = last ? 1 : 10;
      settled = d.head<3>().norm() < 2e-4 * fine && d.tail<3>().norm() < 1e-3 * fine;
    }
  }
  r.T_target_source = orthonormalised(r.T_target_source);
  const Sums sums =
      linearise(target, source, r.T_target_source, r.T_target_source * mean, config.fine_reach_m, config.threads);
  describe(r, sums, source.size());
  if (sums.inliers < enough) return r;
  r.status = !settled                                        ? RegistrationStatus::not_converged
             : r.direction_hold[0] < config.degenerate_below ? RegistrationStatus::degenerate
                                                             : RegistrationStatus::converged;
  return r;
}

}  // namespace headframe
