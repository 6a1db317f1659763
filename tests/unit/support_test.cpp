// How sure placements are, over chains and loops of merges.
#include "server/atlas/support.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace headframe {
namespace {

Alignment merge(SessionId a, SessionId b, double probability, double spread_m = 0) {
  Alignment k;
  k.id = 10 * a + b;
  k.a = a;
  k.b = b;
  k.state = AlignmentState::published;
  k.evidence.probability = probability;
  k.evidence.overlap_m = 20;
  k.evidence.spread_m = spread_m;
  return k;
}

Atlas one_component(SessionId anchor, SessionId last) {
  Component all{anchor, {}};
  for (SessionId s = 1; s <= last; ++s) all.placements.push_back({s, Pose::Identity()});
  return {1, {all, {99, {{99, Pose::Identity()}}}}};
}

// 1 --.99-- 2 --.95-- 3
//  \                 /
//   ------.92-------
TEST(Support, ASessionIsAsSureAsTheLeastSureMergeOfItsSurestWay) {
  Atlas atlas = one_component(1, 3);
  const std::vector<Alignment> merges{merge(1, 2, 0.99), merge(2, 3, 0.95), merge(1, 3, 0.92)};
  add_supports(atlas, merges);
  const Component& all = atlas.components[0];
  ASSERT_EQ(all.supports.size(), 3U);
  EXPECT_EQ(support_in(all, 1)->merged_with, 0) << "it is the anchor";
  EXPECT_EQ(support_in(all, 1)->probability, 1);
  EXPECT_EQ(support_in(all, 1)->deviation_m, 0);
  EXPECT_EQ(support_in(all, 2)->probability, 0.99);
  EXPECT_EQ(support_in(all, 3)->probability, 0.95);
  EXPECT_EQ(support_in(all, 3)->merged_with, 2);
  EXPECT_EQ(support_in(all, 3)->merges, 2);
  EXPECT_EQ(support_in(all, 3)->shared_m, 20);
  EXPECT_TRUE(atlas.components[1].supports.empty()) << "it stands alone";
  EXPECT_EQ(support_in(all, 4), nullptr);
}

TEST(Support, TheAnchorIsWhereWaysBegin) {
  Atlas atlas = one_component(3, 3);
  const std::vector<Alignment> merges{merge(1, 2, 0.99), merge(2, 3, 0.95)};
  add_supports(atlas, merges);
  EXPECT_EQ(support_in(atlas.components[0], 1)->merged_with, 2);
  EXPECT_EQ(support_in(atlas.components[0], 1)->probability, 0.95);
  EXPECT_EQ(support_in(atlas.components[0], 2)->merged_with, 3);
}

TEST(Support, VariancesAddUpAlongTheWay) {
  Atlas atlas = one_component(1, 3);
  const std::vector<Alignment> merges{merge(1, 2, 0.99, 0), merge(2, 3, 0.95, 0.4)};
  add_supports(atlas, merges);
  const auto two = *support_in(atlas.components[0], 2), three = *support_in(atlas.components[0], 3);
  const double least_rad = 0.3 * std::numbers::pi / 180;
  EXPECT_NEAR(two.deviation_m, 0.1, 1e-12);
  EXPECT_NEAR(two.deviation_rad, least_rad, 1e-12);
  EXPECT_NEAR(three.deviation_m, std::sqrt(0.1 * 0.1 + 0.1 * 0.1 + 0.4 * 0.4), 1e-12);
  EXPECT_NEAR(three.deviation_rad, std::sqrt(2 * least_rad * least_rad + 0.02 * 0.02), 1e-12);
}

TEST(Support, WhatIsNotPublishedHoldsNothingAndTheOperatorsWordIsTold) {
  Atlas atlas = one_component(1, 3);
  std::vector<Alignment> merges{merge(1, 2, 0.4), merge(2, 3, 0.95)};
  merges[0].ruling = Ruling::confirmed;
  merges[1].state = AlignmentState::verified;
  add_supports(atlas, merges);
  EXPECT_TRUE(support_in(atlas.components[0], 2)->confirmed);
  EXPECT_EQ(support_in(atlas.components[0], 2)->merges, 1);
  EXPECT_EQ(support_in(atlas.components[0], 3), nullptr);
  add_supports(atlas, {});
  EXPECT_EQ(atlas.components[0].supports.size(), 1U) << "the anchor alone: what was said before is gone";
}

}  // namespace
}  // namespace headframe
