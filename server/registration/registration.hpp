#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/se3.hpp"

namespace headframe {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

enum class RegistrationStatus {
  converged,
  not_converged,      // the last stage ran out of iterations
  degenerate,         // converged, but a direction is not held (Registration::free_directions)
  too_little_overlap  // hardly any source point has a partner; T is the last iterate and meaningless
};

std::string_view to_string(RegistrationStatus status);

/// A direction of motion that the partners' normals hardly hold.
struct FreeDirection {
  enum class Kind { translation, rotation };
  Kind kind = Kind::translation;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // unit, in the target frame; rotations are about the centre
  double hold = 0;                                  // 0: free; 1: held fully by every normal
};

/// Distances of the inliers from their partners' planes, m.
struct Residuals {
  double median_m = 0, p90_m = 0, p99_m = 0;
};

struct Registration {
  Pose T_target_source = Pose::Identity();
  RegistrationStatus status = RegistrationStatus::too_little_overlap;
  int iterations = 0;
  double inlier_fraction = 0;  // source points with a partner in the last stage's reach whose normal agrees
  double rmse_m = 0;           // of the inliers' distances along the target's normal
  Residuals residuals;
  /// J^T W J at the last step, about the source's centre, rotation first (1/rad^2, 1/m^2, mixed).
  Matrix6d information = Matrix6d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // of the source, in the target frame
  /// Eigenvalues of the mean outer product of the partners' normals, ascending; they sum to 1. A long smooth tunnel has
  /// a first value near 0: nothing holds the translation along its axis.
  Eigen::Vector3d direction_hold = Eigen::Vector3d::Zero();
  Eigen::Vector3d weakest_direction = Eigen::Vector3d::UnitX();  // unit, in the target frame
  std::vector<FreeDirection> free_directions;                    // weakest first; empty unless the fit is degenerate
};

/// Text for logs and explanations, like "translation along (1.00, 0.00, 0.02), hold 0.003".
std::string to_string(const FreeDirection& direction);

}  // namespace headframe
