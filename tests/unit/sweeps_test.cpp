#include "client/keyframe/sweeps.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace headframe {
namespace {

constexpr double degree = std::numbers::pi / 180;

Pose at(double x_m, double yaw_deg = 0) { return pose_from_yaw(yaw_deg * degree, {x_m, 0, 0}); }

// How many sweeps a far keyframe gets from these poses, its own scan not counted.
std::size_t kept_of(std::initializer_list<Pose> poses) {
  SweepCollector collector;
  for (const Pose& T : poses) collector.add(T, {{1, 2, 3}});
  return collector.take(at(1000), {}).sweeps.size() - 1;
}

TEST(SweepCollector, KeepsAScanAfterAMetreOrThirtyDegrees) {
  EXPECT_EQ(kept_of({}), 0U);
  EXPECT_EQ(kept_of({at(0)}), 1U);
  EXPECT_EQ(kept_of({at(0), at(0.999)}), 1U);
  EXPECT_EQ(kept_of({at(0), at(1)}), 2U);
  EXPECT_EQ(kept_of({at(0), at(0, 29.9)}), 1U);
  EXPECT_EQ(kept_of({at(0), at(0, 30)}), 2U);
  EXPECT_EQ(kept_of({at(0), at(0.6), at(1.2), at(1.8), at(2.4)}), 3U) << "measured from the last one kept";
}

TEST(SweepCollector, TheLastKeyframeCountsAsKept) {
  SweepCollector collector;
  collector.take(at(0), {});
  collector.add(at(0.999), {{1, 0, 0}});
  EXPECT_EQ(collector.take(at(100), {}).sweeps.size(), 1U);
  collector.add(at(101), {{1, 0, 0}});
  EXPECT_EQ(collector.take(at(200), {}).sweeps.size(), 2U);
}

TEST(SweepCollector, WhenFullTheOldestGoes) {
  SweepConfig config;
  config.most = 3;
  SweepCollector collector(config);
  for (int x = 0; x < 5; ++x) collector.add(at(x), {{0, 0, 1}});
  const KeyframeCloud cloud = collector.take(at(10), {});
  ASSERT_EQ(cloud.sweeps.size(), 4U);
  for (int i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(cloud.sweeps[i].origin.x(), 2.0F + static_cast<float>(i) - 10);
  config.most = 0;
  SweepCollector none(config);
  none.add(at(0), {{0, 0, 1}});
  EXPECT_EQ(none.take(at(10), {}).sweeps.size(), 1U);
}

TEST(SweepCollector, MovesSweepsIntoTheKeyframesFrame) {
  SweepCollector collector;
  collector.add(at(1, 90), {{2, 0, 0}});  // a point at (1, 2, 0) of the local frame
  const KeyframeCloud cloud = collector.take(at(3, 180), {{5, 6, 7}});
  ASSERT_EQ(cloud.sweeps.size(), 2U);
  EXPECT_LT((cloud.sweeps[0].origin - Eigen::Vector3f(2, 0, 0)).norm(), 1e-5);
  ASSERT_EQ(cloud.sweeps[0].points.size(), 1U);
  EXPECT_LT((cloud.sweeps[0].points[0] - Eigen::Vector3f(2, -2, 0)).norm(), 1e-5);
  EXPECT_EQ(cloud.sweeps[1].origin, Eigen::Vector3f::Zero());
  EXPECT_EQ(cloud.sweeps[1].points, (Points{{5, 6, 7}}));
}

// Odometry far from its origin: what floats cannot hold must not reach the cloud.
TEST(SweepCollector, IsExactFarFromTheOrigin) {
  SweepCollector collector;
  collector.add(at(5e6 + 0.123), {{1, 0, 0}});
  const KeyframeCloud cloud = collector.take(at(5e6 + 2.123), {});
  EXPECT_NEAR(cloud.sweeps.at(0).origin.x(), -2, 1e-5);
  EXPECT_NEAR(cloud.sweeps.at(0).points.at(0).x(), -1, 1e-5);
}

TEST(SweepCollector, LeavesOutSweepsAtTheKeyframe) {
  for (const auto& [distance_m, sweeps] : {std::pair{0.999, 1U}, std::pair{1.0, 2U}}) {
    SweepCollector collector;
    collector.add(at(0), {{1, 0, 0}});
    EXPECT_EQ(collector.take(at(distance_m), {}).sweeps.size(), sweeps) << distance_m;
  }
}

TEST(SweepCollector, ThinsEverySweepAndTheOwnScan) {
  const Points close{{1.01F, 0, 0}, {1.02F, 0, 0}};
  const Points apart{{1.01F, 0, 0}, {1.12F, 0, 0}};
  SweepCollector collector;
  collector.add(at(0), close);
  collector.add(at(5), apart);
  const KeyframeCloud cloud = collector.take(at(10), close);
  ASSERT_EQ(cloud.sweeps.size(), 3U);
  EXPECT_EQ(cloud.sweeps[0].points.size(), 1U);
  EXPECT_EQ(cloud.sweeps[1].points.size(), 2U);
  EXPECT_EQ(cloud.sweeps[2].points.size(), 1U);
}

TEST(SweepCollector, IntensitiesGoWithTheirPoints) {
  SweepCollector collector;
  collector.add(at(0), {{1.01F, 0, 0}, {1.02F, 0, 0}, {3, 0, 0}}, {10, 20, 70});
  collector.add(at(5), {{1, 0, 0}});
  const KeyframeCloud cloud = collector.take(at(10, 180), {{2, 0, 0}, {1, 0, 0}}, {5, 6});
  ASSERT_EQ(cloud.sweeps.size(), 3U);
  EXPECT_EQ(cloud.sweeps[0].intensity, (Intensities{15, 70})) << "the mean of each cube";
  EXPECT_EQ(cloud.sweeps[0].points.size(), 2U);
  EXPECT_TRUE(cloud.sweeps[1].intensity.empty());
  EXPECT_EQ(cloud.sweeps[2].intensity, (Intensities{5, 6}));
}

TEST(SweepCollector, TakeEmptiesTheCollector) {
  SweepCollector collector;
  collector.add(at(0), {{1, 0, 0}});
  EXPECT_EQ(collector.take(at(10), {}).sweeps.size(), 2U);
  EXPECT_EQ(collector.take(at(20), {}).sweeps.size(), 1U);
}

}  // namespace
}  // namespace headframe
