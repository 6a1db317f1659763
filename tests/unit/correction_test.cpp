#include "server/atlas/correction.hpp"

#include <gtest/gtest.h>

#include <random>

#include "server/atlas/pose_constraint.hpp"
#include "server/verification/evidence.hpp"
#include "server/verification/place_fit.hpp"

namespace headframe {
namespace {

Pose random_pose(std::mt19937_64& random, double turn = 1, double far_m = 20) {
  std::normal_distribution<double> n(0, 1);
  Vector6d d;
  for (Eigen::Index i = 0; i < 6; ++i) d[i] = n(random) * (i < 3 ? turn : far_m);
  return se3_exp(d);
}

/// A registration whose points hold x, y and z as given, and every rotation well.
Registration registration(const Eigen::Vector3d& hold) {
  Registration r;
  r.T_target_source = pose_from_yaw(0.4, {3, 2, 1});
  r.centre = {5, -2, 1};
  r.information.diagonal() << 1e6, 1e6, 1e6, 1e5 * hold.x(), 1e5 * hold.y(), 1e5 * hold.z();
  return r;
}

double along(const PlaceFit& fit, Eigen::Index i) { return fit.information(i, i); }

TEST(PlaceFit, IsAsSureAsItsSurfacesFaceThatWay) {
  const PlaceFit even = place_fit(registration({1. / 3, 1. / 3, 1. / 3}));
  for (const Eigen::Index i : {3, 4, 5}) EXPECT_NEAR(along(even, i), 1 / (place_sigma_m * place_sigma_m), 1e-6);
  const PlaceFit tunnel = place_fit(registration({0.1, 0.5, 0.4}));
  const double sure = 3 / (place_sigma_m * place_sigma_m);
  EXPECT_NEAR(along(tunnel, 3), 0.1 * 0.3 * sure, 1e-6);  // a tenth of the surfaces: by the square
  EXPECT_NEAR(along(tunnel, 4), 0.5 * sure, 1e-6);
}

TEST(PlaceFit, LeavesOpenWhatSlides) {
  const PlaceFit held = place_fit(registration({held_well * 1.01, 0.5, 0.47}));
  const PlaceFit slides = place_fit(registration({held_well * 0.95, 0.5, 0.47}));
  EXPECT_GT(along(held, 3), 1);
  EXPECT_NEAR(along(slides, 3), 0, 1e-9);
  EXPECT_GT(along(slides, 4), 100);
  Registration turns = registration({0.3, 0.3, 0.4});
  turns.free_directions.push_back({FreeDirection::Kind::rotation, Eigen::Vector3d::UnitZ(), 0.001});
  EXPECT_NEAR(along(place_fit(turns), 2), 0, 1e-9);
  EXPECT_GT(along(place_fit(turns), 1), 100);
  EXPECT_TRUE(place_fit(Registration{}).information.isZero());
}

/// What an increment costs, measured on the pose that it leads to.
double cost(const PlaceFit& fit, const Pose& T_moved) {
  const Pose to_centre(Eigen::Translation3d(-fit.about));
  const Vector6d d = se3_log(to_centre * T_moved * fit.T_a_b.inverse() * to_centre.inverse());
  return d.dot(fit.information * d);
}

// Finite steps, seen from the sessions and from the keyframes, cost the same.
TEST(PlaceFit, InformationSurvivesEveryChangeOfFrame) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20; ++i) {
    Registration r = registration({0.2, 0.5, 0.3});
    const Matrix6d mixed = Matrix6d::Random();
    r.information = (r.information + 1e4 * mixed * mixed.transpose()).eval();
    r.T_target_source = random_pose(random);
    const PlaceFit fit = place_fit(r);
    const Pose T_a_from = random_pose(random), T_b_to = random_pose(random);
    const PoseConstraint c = constraint_between({1, 2}, T_a_from, {2, 3}, T_b_to, fit);
    EXPECT_TRUE(c.T_from_to.isApprox(T_a_from.inverse() * fit.T_a_b * T_b_to, 1e-9));
    const Vector6d d = 1e-4 * Vector6d::Random();
    const Pose T_moved = T_a_from * c.T_from_to * se3_exp(d) * T_b_to.inverse();
    const double expected = cost(fit, T_moved);
    EXPECT_NEAR(d.dot(c.information * d) / expected, 1, 1e-2);
  }
}

TEST(Correction, IsExactAtItsKeyframesRigidOutsideAndBlendedBetween) {
  std::mt19937_64 random(3);
  const Pose T_10 = random_pose(random, 0.01, 0.5), T_20 = random_pose(random, 0.01, 0.5);
  const Correction correction{1, {{10, T_10}, {20, T_20}}};
  const Pose T_local = random_pose(random);
  for (const std::uint64_t sequence : {1, 9, 10})
    EXPECT_TRUE(correction.corrected(sequence, T_local).isApprox(T_10 * T_local, 1e-12)) << sequence;
  for (const std::uint64_t sequence : {20, 21, 999})
    EXPECT_TRUE(correction.corrected(sequence, T_local).isApprox(T_20 * T_local, 1e-12)) << sequence;
  const Pose middle = correction.corrected(15, T_local);
  EXPECT_TRUE(middle.translation().isApprox(((T_10 * T_local).translation() + (T_20 * T_local).translation()) / 2));
  EXPECT_NEAR(rotation_angle_rad((T_10 * T_local).inverse() * middle),
              rotation_angle_rad(middle.inverse() * T_20 * T_local), 1e-9);
}

}  // namespace
}  // namespace headframe
