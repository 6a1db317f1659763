// From pairs of points to a level placement, and what is refused.
#include "server/atlas/rough_placement.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace headframe {
namespace {

const Pose T_a_b = pose_from_yaw(2.5, {100, -40, 3});

std::vector<PointPair> seen_at(const std::vector<Eigen::Vector3d>& in_b) {
  std::vector<PointPair> pairs;
  pairs.reserve(in_b.size());
  for (const Eigen::Vector3d& p : in_b) pairs.push_back({T_a_b * p, p});
  return pairs;
}

TEST(RoughPlacement, IsFoundFromThreePairsAndFromNumbers) {
  const auto found = rough_placement(seen_at({{0, 0, 0}, {20, 1, 0}, {3, 15, 2}}));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->isApprox(T_a_b, 1e-9));
  const auto given = rough_placement({100, -40, 3}, 2.5 * 180 / M_PI);
  ASSERT_TRUE(given);
  EXPECT_TRUE(given->isApprox(T_a_b, 1e-9));
}

TEST(RoughPlacement, StaysLevelWhereClicksAreNot) {
  auto pairs = seen_at({{0, 0, 0}, {20, 0, 0}, {0, 20, 0}, {20, 20, 0}});
  pairs[0].p_a_m.z() += 3;  // a roof was clicked
  pairs[2].p_a_m += Eigen::Vector3d(1, -1, 0);
  const auto found = rough_placement(pairs);
  ASSERT_TRUE(found);
  EXPECT_NEAR((*found * Eigen::Vector3d::UnitZ() - found->translation()).z(), 1, 1e-12);
  EXPECT_LT((found->translation() - T_a_b.translation()).norm(), 2);
}

TEST(RoughPlacement, EachLimitHasTwoSides) {
  EXPECT_FALSE(rough_placement(seen_at({{0, 0, 0}, {9, 0, 0}})));
  const auto spread = [](double s) { return rough_placement(seen_at({{-s, 0, 0}, {s, 0, 0}, {-s, 0, 5}, {s, 0, 5}})); };
  EXPECT_FALSE(spread(0.99));
  EXPECT_TRUE(spread(1.01));
  const auto off = [](double metres) {  // in height, which no turn takes up: rms is half of it, around the mean
    auto pairs = seen_at({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {50, 50, 0}});
    pairs[0].p_a_m.z() += metres;
    pairs[3].p_a_m.z() += metres;
    return rough_placement(pairs);
  };
  EXPECT_TRUE(off(9.9));
  EXPECT_FALSE(off(10.1));
  EXPECT_TRUE(rough_placement({1e8, 0, 0}, 0));
  EXPECT_FALSE(rough_placement({1.1e8, 0, 0}, 0));
  EXPECT_FALSE(rough_placement({0, 0, 0}, std::numeric_limits<double>::quiet_NaN()));
  auto endless = seen_at({{0, 0, 0}, {20, 1, 0}, {3, 15, 2}});
  endless[1].p_a_m.x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(rough_placement(endless));
}

}  // namespace
}  // namespace headframe
