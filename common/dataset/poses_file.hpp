#pragma once
// TUM trajectories: lines of `t x y z qx qy qz qw`.

#include <string_view>
#include <vector>

#include "common/geometry/se3.hpp"
#include "common/result.hpp"

namespace headframe::dataset {

struct StampedPose {
  double stamp_s = 0;
  Pose T_local_sensor = Pose::Identity();
};

/// Blank lines and lines that begin with '#' are skipped. Quaternions are normalised. bad_input, naming the line: a
/// line without 8 finite numbers, a quaternion of length zero, or a stamp that is not after the previous one. Pure.
Result<std::vector<StampedPose>> parse_poses(std::string_view text);

}  // namespace headframe::dataset
