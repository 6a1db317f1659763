#pragma once

#include <functional>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/registration/normal_equations.hpp"

namespace headframe {

/// One pass over the source points with the pose T. The increment rotates about `centre`, a point in the target frame.
/// `distances_m`, if not null, gets the inliers' distances from their partners' planes.
using Linearise =
    std::function<NormalEquations(const Pose& T, const Eigen::Vector3d& centre, std::vector<float>* distances_m)>;

/// One stage, from coarse to fine.
struct Stage {
  Linearise linearise;
  double source_points = 0;  // number of points in one pass
};

struct GaussNewtonConfig {
  int iterations = 15;              // limit for each stage
  double least_inliers = 0.1;       // share of the stage's source points
  double degenerate_below = 0.012;  // hold of a direction below which it counts as free (Registration::direction_hold)
  double gravity_stiffness = 0.5;   // of a spring that keeps z along gravity until the last stage; 0: none
};

/// Runs Gauss-Newton through the stages, starting from T_0; the last stage determines the result. `mean` is the mean of
/// the source points, in the source frame.
Registration gauss_newton(const std::vector<Stage>& stages, const Pose& T_target_source_0, const Eigen::Vector3d& mean,
                          const GaussNewtonConfig& config);

Eigen::Vector3d mean_point(const Points& points);

}  // namespace headframe
