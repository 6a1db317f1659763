#include "common/geometry/se3.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headframe {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Pose se3_exp(const Vector6d& d) {
  const Eigen::Vector3d w = d.head<3>();
  const double angle = w.norm();
  const Eigen::Matrix3d W = skew(w);
  // Left Jacobian of SO(3); the series below 1e-6 rad avoids 0/0.
  const bool tiny = angle < 1e-6;
  const double b = tiny ? 0.5 - angle * angle / 24 : (1 - std::cos(angle)) / (angle * angle);
  const double c = tiny ? 1.0 / 6 - angle * angle / 120 : (angle - std::sin(angle)) / (angle * angle * angle);
  const Eigen::Matrix3d V = Eigen::Matrix3d::Identity() + b * W + c * W * W;
  Pose T = Pose::Identity();
  if (angle > 0) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = V * d.tail<3>();
  return T;
}

Vector6d se3_log(const Pose& T) {
  const Eigen::AngleAxisd aa(Eigen::Quaterniond(T.linear()).normalized());
  const Eigen::Vector3d w = aa.angle() * aa.axis();
  const double angle = aa.angle();
  const Eigen::Matrix3d W = skew(w);
  const double c =
      angle < 1e-4 ? 1.0 / 12 : 1 / (angle * angle) - (1 + std::cos(angle)) / (2 * angle * std::sin(angle));
  const Eigen::Matrix3d V_inv = Eigen::Matrix3d::Identity() - 0.5 * W + c * W * W;
  Vector6d d;
  d << w, V_inv * T.translation();
  return d;
}

double rotation_angle_rad(const Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

double yaw_rad(const Pose& T) { return std::atan2(T.linear()(1, 0), T.linear()(0, 0)); }

double tilt_rad(const Pose& T) { return std::acos(std::clamp(T.linear()(2, 2), -1.0, 1.0)); }

double wrap_rad(double angle_rad) {
  const double two_pi = 2 * std::numbers::pi;
  const double r = angle_rad - two_pi * std::round(angle_rad / two_pi);
  return r <= -std::numbers::pi ? r + two_pi : r;
}

Pose pose_from_yaw(double yaw, const Eigen::Vector3d& translation_m) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = translation_m;
  return T;
}

Pose levelled(const Pose& T_local_sensor) {
  return pose_from_yaw(yaw_rad(T_local_sensor), T_local_sensor.translation());
}

Pose orthonormalised(const Pose& T) {
  Pose out = T;
  out.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return out;
}

}  // namespace headframe
