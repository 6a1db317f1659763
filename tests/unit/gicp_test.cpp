#include "tests/bench/registration/gicp.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
constexpr double degree = std::numbers::pi / 180;

/// A crossing of two drifts with a niche: everything is held.
const BoxMine& crossing() {
  static const BoxMine mine(
      {BoxMine::drift(-30, 0, 30, 0), BoxMine::drift(0, -30, 0, 30), BoxMine::drift(8, 0, 8, 5, 3, 2)});
  return mine;
}

Surfels seen_from(const BoxMine& mine, const Pose& T_mine_sensor, unsigned seed) {
  std::mt19937 rng(seed);
  return make_surfels(voxel_grid(mine.scan(T_mine_sensor, rng), 0.25F));
}

const Pose T_a = pose_from_yaw(0, {0, 0, 1.2});
const Pose T_b = pose_from_yaw(0.6, {1.5, 0.5, 1.4});

TEST(Gicp, FindsTheTruthFromWithinItsBasin) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_b, 2);
  const Pose truth = T_a.inverse() * T_b;
  for (const double yaw_deg : {-15.0, 0.0, 15.0}) {
    const Pose start = pose_from_yaw(0.6 + yaw_deg * degree, truth.translation() + Eigen::Vector3d(0.8, -0.6, 0.1));
    const Registration r = align(a, b, start, {});
    EXPECT_EQ(r.status, RegistrationStatus::converged) << yaw_deg;
    EXPECT_LT((r.T_target_source.translation() - truth.translation()).norm(), 0.03) << yaw_deg;
    EXPECT_LT(rotation_angle_rad(truth.inverse() * r.T_target_source), 0.2 * degree) << yaw_deg;
    EXPECT_NEAR(r.T_target_source.linear().determinant(), 1.0, 1e-9);
  }
}

TEST(Gicp, SwappingGivesTheInverse) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_b, 2);
  const Pose start = T_a.inverse() * T_b;
  const Pose there = align(a, b, start, {}).T_target_source, back = align(b, a, start.inverse(), {}).T_target_source;
  EXPECT_LT((there * back).translation().norm(), 0.02);
  EXPECT_LT(rotation_angle_rad(there * back), 0.2 * degree);
}

TEST(Gicp, TurningTheTargetTurnsTheResult) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_b, 2);
  const Pose start = T_a.inverse() * T_b, move = pose_from_yaw(2.0, {100, -50, 3});
  Points moved;
  for (const auto& p : a.points) moved.push_back((move * p.cast<double>()).cast<float>());
  const Pose plain = align(make_surfels(a.points), b, start, {}).T_target_source;
  const Pose turned = align(make_surfels(moved), b, move * start, {}).T_target_source;
  EXPECT_LT((plain.inverse() * move.inverse() * turned).translation().norm(), 0.01);
}

TEST(Gicp, ThreadsDoNotChangeTheResult) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_b, 2);
  const Pose start = pose_from_yaw(0.5, {1, 1, 0});
  GicpConfig one, many;
  many.threads = 5;
  const Registration r = align(a, b, start, one), s = align(a, b, start, many);
  EXPECT_EQ(r.T_target_source.matrix(), s.T_target_source.matrix());
  EXPECT_EQ(r.information, s.information);
}

TEST(Gicp, SaysThatASmoothDriftDoesNotHoldItsAxis) {
  const BoxMine drift({BoxMine::drift(-200, 0, 200, 0)});
  const Surfels a = seen_from(drift, T_a, 1), b = seen_from(drift, pose_from_yaw(0, {3, 0.2, 1.2}), 2);
  const Registration r = align(a, b, Pose::Identity(), {});
  EXPECT_EQ(r.status, RegistrationStatus::degenerate);
  EXPECT_GT(std::abs(r.weakest_direction.x()), 0.99);
  EXPECT_EQ(align(seen_from(crossing(), T_a, 1), seen_from(crossing(), T_a, 2), Pose::Identity(), {}).status,
            RegistrationStatus::converged);
}

TEST(Gicp, BadCloudsGiveAStatus) {
  const Surfels good = seen_from(crossing(), T_a, 1);
  Points line, dot(50, Eigen::Vector3f(1, 1, 1));
  for (int i = 0; i < 100; ++i) line.emplace_back(0.1F * static_cast<float>(i), 0, 0);
  Points far = good.points, huge = good.points;
  for (auto& p : far) p.x() += 1000;
  for (auto& p : huge) p *= 1000;
  for (const Points& bad : {Points{}, Points(10, Eigen::Vector3f::Zero()), line, dot, far, huge}) {
    EXPECT_EQ(align(good, make_surfels(bad), Pose::Identity(), {}).status, RegistrationStatus::too_little_overlap);
    EXPECT_EQ(align(make_surfels(bad), good, Pose::Identity(), {}).status, RegistrationStatus::too_little_overlap);
  }
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(align(good, good, broken, {}).status, RegistrationStatus::too_little_overlap);
}

}  // namespace
}  // namespace headframe
