#pragma once

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe {

/// PCL's Generalized-ICP from T_target_source_0: covariances from 20 neighbours, correspondences up to 1 m. Returns the
/// start if PCL finds too few points to align, or fails. Both clouds near zero, in metres. Thread safe.
Pose pcl_gicp(const Points& target, const Points& source, const Pose& T_target_source_0 = Pose::Identity());

}  // namespace headframe
