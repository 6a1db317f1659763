#include "server/place/likely_height.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace headframe {
namespace {

std::vector<Keyframe> path(std::initializer_list<Eigen::Vector3d> positions) {
  std::vector<Keyframe> out;
  for (const auto& p : positions) out.emplace_back().T_local_sensor.translation() = p;
  return out;
}

/// 30 m along x on the ground, and back on a level 6 m above it.
const std::vector<Keyframe> two_levels = path({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0}, {20, 1, 6}, {10, 1, 6}});

TEST(LikelyHeight, MostKeyframesTellItThoughTheNearestTwoStandOnTwoLevels) {
  const auto b = path({{0, -2, 1}, {10, -2, 1}, {20, 1, 1}, {30, -2, 1}});  // the third stands right below a's end
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, b, Pose::Identity()), -1);
}

TEST(LikelyHeight, TheKeyframesThatShowOnePlaceTellTheLevel) {
  const auto b = path({{0, -2, 1}, {10, -2, 1}, {20, 1, 1}, {30, -2, 1}});
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, b, Pose::Identity(), 4.5), 5);
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, b, Pose::Identity(), 0.0), -1);
}

TEST(LikelyHeight, WhatThePlacementItselfSaysOfTheHeightDoesNotMatter) {
  const auto b = path({{0, 2, 1}, {10, 2, 1}});
  const Pose up(Eigen::Translation3d(0, -2, 40));
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, b, up),
                   likely_height_m(two_levels, b, Pose(Eigen::Translation3d(0, -2, 0))));
}

TEST(LikelyHeight, IfNoneAreCloseWhatIsToldCountsElseTheNearestTwo) {
  const auto close = path({{-3.9, 0, 1}}), far = path({{-4.1, 0, 1}, {-60, 0, 9}});
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, close, Pose::Identity(), 7), -1);
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, far, Pose::Identity(), 7), 7);
  EXPECT_DOUBLE_EQ(likely_height_m(two_levels, far, Pose::Identity()), -1);
}

TEST(LikelyHeight, OfNothingItIsZero) {
  EXPECT_EQ(likely_height_m({}, {}, Pose::Identity()), 0);
  EXPECT_EQ(likely_height_m(two_levels, {}, Pose::Identity()), 0);
  EXPECT_EQ(likely_height_m({}, {}, Pose::Identity(), 2), 2);
}

}  // namespace
}  // namespace headframe
