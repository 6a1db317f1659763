#pragma once

#include <span>

#include "common/geometry/se3.hpp"
#include "common/result.hpp"

namespace headframe {

/// One spot of the mine as picked in the maps of two sessions, in their frames.
struct PointPair {
  Eigen::Vector3d p_a_m = Eigen::Vector3d::Zero(), p_b_m = Eigen::Vector3d::Zero();
};

/// The horizontal placement (both frames have z along gravity) that fits the pairs by least squares. invalid_argument,
/// with a one-line message: fewer than three pairs; a number that is not finite or beyond 1e8 m; all points within 1 m
/// of one spot, which leaves the yaw undetermined; or pairs that contradict each other by more than 5 m (root mean
/// square).
Result<Pose> rough_placement(std::span<const PointPair> pairs);

/// The placement with b's origin at p_a_m in a's frame and b rotated by yaw. Checks its numbers likewise.
Result<Pose> rough_placement(const Eigen::Vector3d& p_a_m, double yaw_deg);

}  // namespace headframe
