#include "server/atlas/change_list.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

const Pose T_2 = pose_from_yaw(1, {100, 0, 0}), T_3 = pose_from_yaw(-1, {0, 50, 0});
const Atlas atlas{1, {{1, {{1, Pose::Identity()}, {2, T_2}, {3, T_3}}}}};

Alignment published(AlignmentId id, SessionId a, SessionId b, const Pose& T_a_b, std::vector<Change> changes) {
  Alignment out{id, a, b, AlignmentState::published, T_a_b, {}};
  out.changes = std::move(changes);
  return out;
}

Change face(const Eigen::Vector3d& p_a, double older_s, double newer_s, bool a_is_newer = false) {
  return {ChangeKind::excavated, p_a, 4, 1, 3, a_is_newer, older_s, newer_s};
}

TEST(ChangeList, LiesWhereTheOlderSessionIsOnTheMap) {
  const Alignment first = published(1, 2, 3, T_2.inverse() * T_3, {face({1, 2, 3}, 10, 20)}),
                  second = published(2, 2, 3, T_2.inverse() * T_3, {face({1, 2, 3}, 10, 20, true)});
  const auto one = changes_of(first, atlas), other = changes_of(second, atlas);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].component, 1);
  EXPECT_EQ(std::pair(one[0].older, one[0].newer), (std::pair<SessionId, SessionId>(2, 3)));
  EXPECT_LT((one[0].p - T_2 * Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
  EXPECT_EQ(std::pair(other[0].older, other[0].newer), (std::pair<SessionId, SessionId>(3, 2)));
  EXPECT_LT((other[0].p - one[0].p).norm(), 1e-9) << "the alignment is what the atlas has";
  const auto apart = changes_of(first, Atlas{1, {{2, {{2, T_2}}}, {3, {{3, T_3}}}}});
  EXPECT_EQ(apart[0].component, 0);
  EXPECT_EQ(apart[0].p, Eigen::Vector3d(1, 2, 3)) << "in the older session's frame";
}

TEST(ChangeList, WhatSeveralPairsTellIsListedOnceBetweenTheNearestDates) {
  const Eigen::Vector3d there(10, 0, 0);
  const Alignment wide = published(1, 1, 2, T_2, {face(there, 100, 900)}),
                  narrow = published(2, 1, 3, T_3, {face(there + Eigen::Vector3d(1, 0, 0), 400, 600)}),
                  elsewhere = published(3, 2, 3, T_2.inverse() * T_3,
                                        {face(T_2.inverse() * Eigen::Vector3d(20, 0, 0), 100, 700)});
  const auto all = changes_since(0, {&wide, &narrow, &elsewhere}, atlas);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].change.newer_s, 700) << "the newest first";
  EXPECT_EQ(all[1].change.older_s, 400);
  EXPECT_EQ(all[1].change.newer_s, 600);
  EXPECT_EQ(all[1].alignment, 2);
  EXPECT_EQ(all[1].newer, 3);
  EXPECT_EQ(changes_since(650, {&wide, &narrow, &elsewhere}, atlas).size(), 1U);
  const Alignment again = published(2, 1, 3, T_3, {face(there, 950, 990)});
  EXPECT_EQ(changes_since(0, {&wide, &again}, atlas).size(), 2U) << "driven on twice: first by 900, then after 950";
}

TEST(ChangeList, HasOnlyWhatIsPublished) {
  Alignment candidate = published(1, 1, 2, T_2, {face({0, 0, 0}, 1, 2)});
  EXPECT_EQ(changes_since(0, {&candidate}, atlas).size(), 1U);
  candidate.state = AlignmentState::candidate;
  EXPECT_TRUE(changes_since(0, {&candidate}, atlas).empty());
}

}  // namespace
}  // namespace headframe
