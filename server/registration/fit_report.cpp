#include "server/registration/fit_report.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace headframe {
namespace {

double quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(at)]);
}

/// Finds rotations about axes through the centre that are hardly held: their stiffness relative to what it would be if
/// every normal pointed in the direction in which its point would move.
void add_free_rotations(const NormalEquations& sums, double below, std::vector<FreeDirection>& out) {
  const double stiffness = sums.H.bottomRightCorner<3, 3>().trace() / std::max(1.0, sums.inliers);
  const Eigen::Matrix3d most = stiffness * (sums.levers.trace() * Eigen::Matrix3d::Identity() - sums.levers) +
                               1e-9 * Eigen::Matrix3d::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sums.H.topLeftCorner<3, 3>(), most);
  for (Eigen::Index i = 0; i < 3; ++i)
    if (eigen.eigenvalues()[i] < below)
      out.push_back({FreeDirection::Kind::rotation, eigen.eigenvectors().col(i).normalized(), eigen.eigenvalues()[i]});
}

}  // namespace

void report_fit(Registration& r, const NormalEquations& sums, double source_points, double degenerate_below,
                std::vector<float> distances_m) {
  r.information = sums.H;
  r.inlier_fraction = sums.inliers / source_points;
  r.rmse_m = std::sqrt(sums.squared_plane_m2 / std::max(1.0, sums.inliers));
  r.residuals = {quantile(distances_m, 0.5), quantile(distances_m, 0.9), quantile(distances_m, 0.99)};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sums.normals / std::max(1.0, sums.inliers));
  r.direction_hold = eigen.eigenvalues();
  r.weakest_direction = eigen.eigenvectors().col(0);
  for (Eigen::Index i = 0; i < 3; ++i)
    if (r.direction_hold[i] < degenerate_below)
      r.free_directions.push_back({FreeDirection::Kind::translation, eigen.eigenvectors().col(i), r.direction_hold[i]});
  add_free_rotations(sums, degenerate_below, r.free_directions);
  std::stable_sort(r.free_directions.begin(), r.free_directions.end(),
                   [](const auto& a, const auto& b) { return a.hold < b.hold; });
}

std::string to_string(const FreeDirection& d) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%s (%.2f, %.2f, %.2f), hold %.3f",
                d.kind == FreeDirection::Kind::translation ? "translation along" : "rotation about", d.axis.x(),
                d.axis.y(), d.axis.z(), d.hold);
  return text.data();
}

}  // namespace headframe
