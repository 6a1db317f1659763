// An operator lays one drive on another in a drawn mine: roughly right, wrong, where nothing is.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::Base;

/// The pipeline does not merge the two by itself: it is never asked to.
struct TwoDrives : Base {
  TwoDrives() : Base({test::drive_a_to_c(1), test::drive_b_to_a(1)}) {}
  Pose T_1_2() const { return drive(1).T_mine_local.inverse() * drive(2).T_mine_local; }
  /// The truth, moved and turned in the middle of what both have driven, the last third of b's drive.
  Pose off(const Eigen::Vector3d& by_m, double deg) const {
    const Eigen::Vector3d p = position(drive(2).keyframes[drive(2).keyframes.size() * 5 / 6]);
    Pose T = T_1_2();
    T.linear() = pose_from_yaw(deg * std::numbers::pi / 180, {0, 0, 0}).linear() * T.linear();
    T.translation() = T_1_2() * p - T.linear() * p + by_m;
    return T;
  }
  Result<HandPlacement> place(const Pose& T_1_2) {
    report = {};
    return pipeline.place(1, 2, T_1_2, shelf, report);
  }
  double error_m(const Pose& T) const {
    double worst = 0;  // over the drive
    for (const Keyframe& k : drive(2).keyframes)
      worst = std::max(worst, (T * position(k) - T_1_2() * position(k)).norm());
    return worst;
  }
  AttemptReport report;
};

TEST(PlaceByHand, ARoughPlacementIsRefinedAndStaysACandidateUntilItIsConfirmed) {
  TwoDrives base;
  for (const double deg : {10, -10}) {
    const Pose T_rough = base.off({1.2, deg > 0 ? -1.6 : 1.6, 0.3}, deg);  // 2 m
    ASSERT_GT(base.error_m(T_rough), 2);
    const auto placed = base.place(T_rough);
    ASSERT_TRUE(placed) << placed.error().message;
    EXPECT_TRUE(placed->recorded) << deg << " deg, probability " << placed->alignment.evidence.probability;
    EXPECT_LT(base.error_m(placed->alignment.T_a_b), 0.3) << deg;
    EXPECT_GT(placed->moved_m, 1);
    EXPECT_NEAR(placed->turned_rad, 10 * std::numbers::pi / 180, 0.03);
    EXPECT_EQ(placed->alignment.state, AlignmentState::candidate);
    EXPECT_EQ(placed->alignment.ruling, Ruling::placed);
    EXPECT_GT(placed->alignment.evidence.probability, 0.5);
    EXPECT_EQ(base.report.changed.size(), 1U);
    ASSERT_EQ(base.report.decided.size(), 1U) << "to be stored";
    EXPECT_EQ(base.report.decided[0].decision, Decision::place);
    EXPECT_FALSE(base.report.atlas_changed);
    EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
  }
  const AlignmentId id = base.pipeline.alignments().at(0).id;
  ASSERT_EQ(base.pipeline.alignments().size(), 1U) << "the second took the place of the first";
  ASSERT_TRUE(base.pipeline.decide(id, Decision::confirm));
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_LT(base.error_m(base.pipeline.alignments().at(0).T_a_b), 0.3);
  EXPECT_EQ(base.place(base.T_1_2()).error().code, ErrorCode::refused) << "they are merged";
}

TEST(PlaceByHand, EitherMayBeLaidOnTheOther) {
  TwoDrives base;
  const auto placed = base.pipeline.place(2, 1, base.off({1, -1, 0}, 5).inverse(), base.shelf, base.report);
  ASSERT_TRUE(placed) << placed.error().message;
  EXPECT_EQ(placed->alignment.a, 1);
  EXPECT_LT(base.error_m(placed->alignment.T_a_b), 0.3);
}

TEST(PlaceByHand, AWrongPlacementIsToldWithItsEvidenceAndTakesNothingAway) {
  TwoDrives base;
  ASSERT_TRUE(base.place(base.off({0.5, 0, 0}, 0)));
  const Alignment right = base.pipeline.alignments().at(0);
  const auto wrong = base.place(base.off({0, 0, 0}, 90));
  ASSERT_TRUE(wrong) << wrong.error().message;
  EXPECT_FALSE(wrong->recorded);
  EXPECT_EQ(wrong->alignment.state, AlignmentState::rejected);
  EXPECT_LT(wrong->alignment.evidence.probability, 0.2);
  EXPECT_TRUE(wrong->alignment.evidence.freespace_violation > 0.02 || wrong->alignment.evidence.matched_share < 0.5);
  EXPECT_TRUE(base.report.changed.empty());
  EXPECT_TRUE(base.report.decided.empty());
  EXPECT_TRUE(base.pipeline.alignments().at(0).T_a_b.isApprox(right.T_a_b));
}

TEST(PlaceByHand, WhereNobodyHasCloudsItSaysSo) {
  TwoDrives base;
  const auto far = base.place(base.off({500, 0, 0}, 0));
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, ErrorCode::refused);
  for (const auto& [keyframe, cloud] : base.shelf.clouds)
    if (keyframe.session == 2) base.shelf.on_robots.insert(keyframe);
  const auto waits = base.place(base.T_1_2());
  ASSERT_FALSE(waits);
  EXPECT_EQ(waits.error().code, ErrorCode::unavailable);
  EXPECT_FALSE(base.report.wanted.empty()) << "they are asked for";
  base.pipeline.add_session(3, ScanContext().id());
  base.report = {};
  EXPECT_EQ(base.pipeline.place(1, 3, Pose::Identity(), base.shelf, base.report).error().code, ErrorCode::refused)
      << "it has no keyframe yet";
  EXPECT_EQ(base.pipeline.place(1, 9, Pose::Identity(), base.shelf, base.report).error().code, ErrorCode::not_found);
  EXPECT_EQ(base.pipeline.place(1, 1, Pose::Identity(), base.shelf, base.report).error().code,
            ErrorCode::invalid_argument);
}

TEST(PlaceByHand, WhatLaterAttemptsFindStandsBesideIt) {
  TwoDrives base;
  ASSERT_TRUE(base.place(base.off({0.5, 0, 0}, 0)));
  const AlignmentId id = base.pipeline.alignments().at(0).id;
  ASSERT_TRUE(base.pipeline.decide(id, Decision::undo));
  EXPECT_EQ(base.pipeline.alignments().at(0).ruling, Ruling::none);
  Base later({base.drive(1), base.drive(2)});
  AttemptReport report;
  ASSERT_TRUE(later.pipeline.place(1, 2, base.T_1_2(), later.shelf, report));
  const DecisionRecord placed = report.decided.at(0);
  Base restarted({base.drive(1), base.drive(2)});
  restarted.pipeline.restore(later.pipeline.alignments(), 1, {placed});
  EXPECT_EQ(restarted.pipeline.alignments().at(0).ruling, Ruling::placed) << "as it was stored";
  EXPECT_EQ(restarted.pipeline.atlas().components.size(), 2U);
  for (const SessionId id_of : {1, 2}) restarted.pipeline.attempt(id_of, restarted.shelf);
  EXPECT_EQ(restarted.pipeline.atlas().components.size(), 1U) << "found by itself, and published for that";
}

}  // namespace
}  // namespace headframe
