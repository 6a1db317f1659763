#pragma once

#include "server/registration/normal_equations.hpp"
#include "server/registration/surfels.hpp"

namespace headframe {

struct GicpConfig {
  double coarse_reach_m = 4.0;  // correspondence radius: starts here ...
  double fine_reach_m = 0.75;   // ... and ends here
  int stages = 4;               // geometric steps between the two
  int iterations = 15;          // at most, in each stage
  double least_inliers = 0.1;   // of the source points
  double degenerate_below = 0.012;
  double gravity_stiffness = 0.5;  // of the spring that keeps z along gravity until the last stage; 0: none
  FactorModel factor;
  int threads = 1;
};

/// Generalized-ICP (Segal et al., RSS 2009), plane to plane: every point's covariance is I - (1 - eps) n n^T, so the
/// normal is all that is kept of it. Deviations: correspondence radius annealed, Geman-McClure weight on the
/// Mahalanobis distance, partners whose normals differ by over 60 deg are left out. Gauss-Newton with Levenberg
/// damping. The result does not depend on the number of threads. Thread safe.
Registration align(const Surfels& target, const Surfels& source, const Pose& T_target_source_0,
                   const GicpConfig& config);

}  // namespace headframe
