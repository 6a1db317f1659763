#pragma once

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe::bench {

/// PCL's Generalized-ICP from identity: 20 neighbours, 1 m correspondences; covariances and alignment together. The
/// baseline of the bench and the oracle of the registration test.
Pose pcl_gicp(const Points& target, const Points& source);

}  // namespace headframe::bench
