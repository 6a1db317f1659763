#pragma once

#include <span>

#include "common/geometry/se3.hpp"
#include "common/result.hpp"

namespace headframe {

/// One spot of the mine, in the frames of two sessions, as somebody sees it in their maps.
struct PointPair {
  Eigen::Vector3d p_a_m = Eigen::Vector3d::Zero(), p_b_m = Eigen::Vector3d::Zero();
};

/// The level placement (both frames have z along gravity) with the least squares. invalid_argument, in one line: fewer
/// than three pairs, a number that is not finite or beyond 1e8 m, pairs within 1 m of one spot, where the turn would be
/// a guess, or pairs that contradict each other by more than 5 m (root mean square).
Result<Pose> rough_placement(std::span<const PointPair> pairs);

/// b's origin at x, y, z of a, b turned by yaw. The same of its numbers.
Result<Pose> rough_placement(const Eigen::Vector3d& p_a_m, double yaw_deg);

}  // namespace headframe
