#pragma once

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe {

/// The roll and pitch of a sensor pose: the transform from the sensor's frame to its levelled frame (same origin and
/// heading, z along gravity).
Pose level_from_sensor(const Pose& T_local_sensor);

/// A scan in the levelled frame, the input of descriptors and wall profiles.
Points level(const Pose& T_local_sensor, const Points& points_sensor);

}  // namespace headframe
