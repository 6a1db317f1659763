#pragma once

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe {

/// Roll and pitch of a sensor, as its pose tells them: what turns its frame into the levelled one (same origin and
/// heading, z along gravity).
Pose level_from_sensor(const Pose& T_local_sensor);

/// A scan in the levelled frame: what descriptors and wall profiles are made of.
Points level(const Pose& T_local_sensor, const Points& points_sensor);

}  // namespace headframe
