#pragma once

#include <functional>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/registration/normal_equations.hpp"

namespace headframe {

/// One pass over the source points with the pose T; `centre` is what the increment turns about, in the target frame.
/// `distances_m`, where not null, gets the inliers' distances from their partners' planes.
using Linearise =
    std::function<NormalEquations(const Pose& T, const Eigen::Vector3d& centre, std::vector<float>* distances_m)>;

/// A step of coarse to fine.
struct Stage {
  Linearise linearise;
  double source_points = 0;  // how many the pass goes over
};

struct GaussNewtonConfig {
  int iterations = 15;              // at most, in each stage
  double least_inliers = 0.1;       // of the stage's source points
  double degenerate_below = 0.012;  // least hold of a direction (Registration::direction_hold)
  double gravity_stiffness = 0.5;   // of the spring that keeps z along gravity until the last stage; 0: none
};

/// Gauss-Newton through the stages from T_0; the last one decides the result's figures. `mean` is the mean of the
/// source points, in the source frame.
Registration gauss_newton(const std::vector<Stage>& stages, const Pose& T_target_source_0, const Eigen::Vector3d& mean,
                          const GaussNewtonConfig& config);

Eigen::Vector3d mean_point(const Points& points);

}  // namespace headframe
