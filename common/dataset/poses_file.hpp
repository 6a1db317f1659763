#pragma once
// TUM trajectories: `t x y z qx qy qz qw` a line.

#include <string_view>
#include <vector>

#include "common/geometry/se3.hpp"
#include "common/result.hpp"

namespace headframe::dataset {

struct StampedPose {
  double stamp_s = 0;
  Pose T_local_sensor = Pose::Identity();
};

/// Lines that are blank or begin with '#' are passed over. Quaternions are normalised. Fails with bad_input and the
/// line when a line has not 8 finite numbers, a quaternion has length zero, or a stamp is not after the one before.
/// Pure.
Result<std::vector<StampedPose>> parse_poses(std::string_view text);

}  // namespace headframe::dataset
