#pragma once

#include <string_view>

#include "common/geometry/se3.hpp"
#include "server/registration/surfels.hpp"

namespace headframe {

enum class RegistrationStatus {
  converged,
  not_converged,      // the last stage ran out of iterations
  degenerate,         // converged, but a translation is not held (Registration::weakest_direction)
  too_little_overlap  // hardly any source point has a partner; T is where it stopped and means nothing
};

std::string_view to_string(RegistrationStatus status);

struct GicpConfig {
  double coarse_reach_m = 4.0;  // correspondence radius: starts here ...
  double fine_reach_m = 0.75;   // ... and ends here
  int stages = 4;               // geometric steps between the two
  int iterations = 15;          // at most, in each stage
  double least_inliers = 0.1;   // of the source points
  double degenerate_below = 0.012;
  double gravity_stiffness = 0.5;  // of the spring that keeps z along gravity until the last stage; 0: none
  int threads = 1;
};

struct Registration {
  Pose T_target_source = Pose::Identity();
  RegistrationStatus status = RegistrationStatus::too_little_overlap;
  int iterations = 0;
  double inlier_fraction = 0;  // source points with a partner within fine_reach_m whose normal agrees
  double rmse_m = 0;           // of the inliers' distances along the target's normal
  /// J^T W J of the last step about the source's centre, rotation first (1/rad^2, 1/m^2, mixed).
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  /// Eigenvalues of the mean outer product of the partners' normals, ascending; they sum to 1. A long smooth drift has
  /// a first value near 0: nothing holds the translation along its axis.
  Eigen::Vector3d direction_hold = Eigen::Vector3d::Zero();
  Eigen::Vector3d weakest_direction = Eigen::Vector3d::UnitX();  // unit, in the target frame
};

/// Generalized-ICP (Segal et al., RSS 2009), plane to plane: every point's covariance is I - (1 - eps) n n^T, so the
/// normal is all that is kept of it. Deviations: correspondence radius annealed, Geman-McClure weight on the
/// Mahalanobis distance, partners whose normals differ by over 60 deg are left out. Gauss-Newton with Levenberg
/// damping. The result does not depend on the number of threads. Thread safe.
Registration align(const Surfels& target, const Surfels& source, const Pose& T_target_source_0,
                   const GicpConfig& config);

}  // namespace headframe
