#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "common/geometry/se3.hpp"

namespace headframe {
namespace {

Vector6d random_twist(std::mt19937& rng, double angle_rad) {
  std::normal_distribution<double> n;
  Eigen::Vector3d axis(n(rng), n(rng), n(rng));
  Vector6d d;
  d << axis.normalized() * angle_rad, n(rng), n(rng), n(rng);
  return d;
}

TEST(Se3, LogUndoesExpUpToHalfATurn) {
  std::mt19937 rng(1);
  for (double angle : {0.0, 1e-9, 1e-5, 0.1, 1.0, 3.0, 3.14}) {
    const Vector6d d = random_twist(rng, angle);
    EXPECT_LT((se3_log(se3_exp(d)) - d).norm(), 1e-6) << "angle " << angle;
  }
}

TEST(Se3, ExpIsARigidMotion) {
  std::mt19937 rng(2);
  const Pose T = se3_exp(random_twist(rng, 2.0));
  EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-12);
  EXPECT_LT((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(Se3, ExpAgreesWithManySmallSteps) {
  std::mt19937 rng(3);
  const Vector6d d = random_twist(rng, 1.5);
  Pose T = Pose::Identity();
  const int steps = 10000;
  for (int i = 0; i < steps; ++i) {
    Pose step = Pose::Identity();
    step.linear() += skew(d.head<3>() / steps);
    step.translation() = d.tail<3>() / steps;
    T = step * T;
  }
  EXPECT_LT((T.matrix() - se3_exp(d).matrix()).norm(), 1e-3);
}

TEST(Se3, YawAndTiltOfALevelledPose) {
  const Pose T = pose_from_yaw(2.0, {1, 2, 3}) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(yaw_rad(T), 2.0, 1e-12);
  EXPECT_NEAR(tilt_rad(T), 0.1, 1e-9);
  EXPECT_NEAR(tilt_rad(levelled(T)), 0.0, 1e-9);
  EXPECT_NEAR(rotation_angle_rad(T.inverse() * levelled(T)), 0.1, 1e-9);
}

TEST(Se3, WrapKeepsHalfTurnPositive) {
  EXPECT_NEAR(wrap_rad(3 * std::numbers::pi), std::numbers::pi, 1e-12);
  EXPECT_NEAR(wrap_rad(-std::numbers::pi), std::numbers::pi, 1e-12);
  EXPECT_NEAR(wrap_rad(-0.1 - 4 * std::numbers::pi), -0.1, 1e-12);
}

}  // namespace
}  // namespace headframe
