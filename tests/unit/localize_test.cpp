// What a robot is told that asks where it is, at both sides of each threshold.
#include "server/merge/localize.hpp"

#include <gtest/gtest.h>

#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

constexpr SessionId asking = 2;

/// Sessions 1 and 3 have mapped 60 m and ended; 2 asks, and has come 40 m.
class Localize : public testing::Test {
 protected:
  void SetUp() override {
    for (const SessionId id : {1, 3}) {
      grow(id, 60);
      sessions_.complete(id);
      sessions_.set_looked_at(id, true);
    }
    grow(asking, 40);
    sessions_.set_asks_where(asking, true);
  }
  void grow(SessionId id, int metres) {
    sessions_.add(id, {"test", 1});
    for (int m = 0; m <= metres; ++m) {
      Keyframe k = line_keyframe(static_cast<std::uint64_t>(m) + 1);
      k.stamp_s = m;
      sessions_.add_keyframe(id, k);
    }
  }

  static Alignment alignment(AlignmentId id, SessionId a, SessionId b, const Pose& T_a_b = Pose::Identity()) {
    Alignment k{id, a, b, AlignmentState::candidate, T_a_b, {}};
    k.evidence.probability = 0.99;
    k.evidence.inlier_fraction = 1;
    k.evidence.overlap_m = 30;
    return k;
  }

  SessionLocalization told(const std::vector<Alignment>& alignments, const Contacts& contacts = nothing_known()) {
    AlignmentBook book(config_, sessions_);
    book.restore(alignments, {}, {});
    AttemptReport report;
    book.update_atlas(
        nothing_known(), [](const auto&) { return Objection(); }, report);
    book.given_out({});
    return localize(asking, sessions_, book, contacts);
  }
  SessionLocalization told_with(double Evidence::*member, double value) {
    Alignment k = alignment(1, 1, asking);
    k.evidence.*member = value;
    return told({k});
  }
  static Contacts nothing_known() {
    return [](SessionId, SessionId, const Pose&) { return Contact::none; };
  }

  const MergeConfig config_{};
  SessionMap sessions_{config_};
};

TEST_F(Localize, SaysWhereTheNewestKeyframeIsAndMergesNothing) {
  const Pose T_1_2 = pose_from_yaw(0.5, {1, 2, 3});
  const SessionLocalization l = told({alignment(1, 1, asking, T_1_2)});
  ASSERT_TRUE(l.found) << l.missing;
  EXPECT_FALSE(l.merged);
  EXPECT_EQ(l.component, 1);
  EXPECT_EQ(l.on, 1);
  EXPECT_EQ(l.keyframe, 41U);
  EXPECT_TRUE(l.T_component_session.isApprox(T_1_2, 1e-12));
  const Pose T_local_sensor = sessions_.at(asking).keyframes.back().T_local_sensor;
  EXPECT_TRUE(l.T_component_sensor.isApprox(T_1_2 * T_local_sensor, 1e-12));
  EXPECT_GT(l.covariance.diagonal().minCoeff(), 0);
  EXPECT_TRUE(l.covariance.isApprox(l.covariance.transpose()));
  EXPECT_EQ(l.missing, "");
}

TEST_F(Localize, TheOtherWayRoundIsTheSame) {
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  const SessionLocalization l = told({alignment(1, asking, 3, T)});
  ASSERT_TRUE(l.found) << l.missing;
  EXPECT_EQ(l.on, 3);
  EXPECT_TRUE(l.T_component_session.isApprox(T.inverse(), 1e-12));
}

TEST_F(Localize, WaitsForPathLikeALiveDriveThatMayBeShorter) {
  EXPECT_TRUE(told_with(&Evidence::overlap_m, SessionMap::localize_m).found);
  const SessionLocalization less = told_with(&Evidence::overlap_m, SessionMap::localize_m - 1.5);
  EXPECT_FALSE(less.found);
  EXPECT_NEAR(less.awaited_m, 1.5, 1e-9);
  EXPECT_NE(less.missing.find("2 m"), std::string::npos) << less.missing;
  sessions_.complete(asking);
  EXPECT_FALSE(told_with(&Evidence::overlap_m, SessionMap::localize_m - 1.5).found) << "also when it rests";
}

TEST_F(Localize, WaitsForMoreWherePlacesLookAlike) {
  Alignment k = alignment(1, 1, asking);
  k.evidence.similar_places = 1;
  k.evidence.overlap_m = SessionMap::localize_m + config_.shown_more_m;
  EXPECT_TRUE(told({k}).found);
  k.evidence.overlap_m -= 0.1;
  EXPECT_FALSE(told({k}).found);
  k.evidence.overlap_m = 1000;
  k.evidence.similar_places = config_.look_alikes;
  EXPECT_TRUE(told({k}).found);
  grow(4, 10);
  EXPECT_FALSE(told({k}).found) << "another robot drives, and may come to contradict it";
}

TEST_F(Localize, WhatDoesNotConvinceIsNotTold) {
  Alignment k = alignment(1, 1, asking);
  k.evidence.overlap_m = 1000;
  k.evidence.probability = config_.accept_probability;
  EXPECT_TRUE(told({k}).found);
  k.evidence.probability -= 0.001;
  EXPECT_FALSE(told({k}).found);
  EXPECT_GT(told({k}).probability, 0.8) << "but it is told how far it has come";
  EXPECT_FALSE(told_with(&Evidence::runner_up, 0.95).found);
}

TEST_F(Localize, ARivalOnAnotherMapCastsDoubt) {
  Alignment best = alignment(1, 1, asking), rival = alignment(2, asking, 3, pose_from_yaw(1, {5, 0, 0}));
  const auto beside = [&](double odds) {
    rival.evidence.probability = odds / (1 + odds);
    return told({best, rival}).found;
  };
  const double odds_of_best = 99;
  EXPECT_TRUE(beside(0.099 * odds_of_best));
  EXPECT_FALSE(beside(0.101 * odds_of_best));
}

TEST_F(Localize, WhatLiesAtTheSamePlaceOfOneMapCastsNone) {
  Alignment of_map = alignment(1, 1, 3);
  of_map.state = AlignmentState::published;
  of_map.evidence.overlap_m = 1000;
  Alignment one = alignment(2, 1, asking), other = alignment(3, asking, 3);
  EXPECT_TRUE(told({of_map, one, other}).found);
  other.T_a_b = pose_from_yaw(0, {2.1, 0, 0});
  EXPECT_FALSE(told({of_map, one, other}).found) << "both can not be right";
}

TEST_F(Localize, AnotherSessionOfTheMapMayContradict) {
  Alignment of_map = alignment(1, 1, 3, pose_from_yaw(0.3, {4, 0, 0}));
  of_map.state = AlignmentState::published;
  const Pose T_1_2 = pose_from_yaw(0.5, {1, 2, 3});
  const auto with = [&](Contact contact) {
    return told({of_map, alignment(2, 1, asking, T_1_2)}, [&](SessionId a, SessionId b, const Pose& T_a_b) {
      EXPECT_EQ(a, asking);
      EXPECT_EQ(b, 3);
      EXPECT_TRUE(T_a_b.isApprox(T_1_2.inverse() * of_map.T_a_b, 1e-9));
      return contact;
    });
  };
  EXPECT_TRUE(with(Contact::none).found);
  EXPECT_FALSE(with(Contact::contradicts).found);
}

TEST_F(Localize, WhatIsMergedIsToldHoweverShort) {
  Alignment k = alignment(1, 1, asking);
  k.evidence.overlap_m = 1;
  EXPECT_FALSE(told({k}).found);
  k.state = AlignmentState::published;
  const SessionLocalization l = told({k});
  EXPECT_TRUE(l.found);
  EXPECT_TRUE(l.merged);
}

TEST_F(Localize, WhatTheOperatorRefusedIsNoPlaceToBe) {
  AlignmentBook book(config_, sessions_);
  AttemptReport report;
  Judgement judged;
  judged.evidence = alignment(1, 1, asking).evidence;
  book.record({1, asking}, judged, std::nullopt, false, report);
  const auto answer = [&] {
    book.update_atlas(
        nothing_known(), [](const auto&) { return Objection(); }, report);
    book.given_out({});
    return localize(asking, sessions_, book, nothing_known());
  };
  EXPECT_TRUE(answer().found) << answer().missing;
  ASSERT_TRUE(book.decide(1, Decision::refuse, report));
  EXPECT_FALSE(answer().found);
}

TEST_F(Localize, WithoutKeyframesOrMapsThereIsNothingToSay) {
  AlignmentBook book(config_, sessions_);
  EXPECT_NE(localize(9, sessions_, book, nothing_known()).missing, "");
  const SessionLocalization l = told({});
  EXPECT_FALSE(l.found);
  EXPECT_EQ(l.on, 0);
  EXPECT_EQ(l.keyframe, 41U);
  EXPECT_NE(l.missing.find("drive on"), std::string::npos);
}

}  // namespace
}  // namespace headframe
