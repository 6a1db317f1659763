#pragma once
// Rigid transforms. A pose is T_target_source: p_target = T_target_source * p_source. Metres and radians.

#include <Eigen/Geometry>

namespace headframe {

using Pose = Eigen::Isometry3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;  // rotation (rad) first, then translation (m), everywhere

/// exp of a left increment: T' = se3_exp(d) * T. d = (rotation vector, translation); any size of rotation.
Pose se3_exp(const Vector6d& d);

/// Inverse of se3_exp; the rotation vector's norm is in [0, pi].
Vector6d se3_log(const Pose& T);

Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// Angle of the rotation, in [0, pi] rad.
double rotation_angle_rad(const Pose& T);

/// Heading of the x axis seen from above: atan2(R10, R00), in (-pi, pi] rad.
double yaw_rad(const Pose& T);

/// Angle between the z axes of both frames: 0 when gravity agrees.
double tilt_rad(const Pose& T);

/// Wraps an angle into (-pi, pi].
double wrap_rad(double angle_rad);

/// Four degrees of freedom, for gravity-aligned frames: Rz(yaw) and a translation.
Pose pose_from_yaw(double yaw_rad, const Eigen::Vector3d& translation_m);

/// The pose of the levelled sensor: same place and heading as T_local_sensor, z along gravity.
Pose levelled(const Pose& T_local_sensor);

/// Makes the rotation orthonormal again (for poses read from text or float).
Pose orthonormalised(const Pose& T);

}  // namespace headframe
