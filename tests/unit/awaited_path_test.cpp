// For how much path a placement waits before it is told, and what waited for others.
#include <gtest/gtest.h>

#include <cmath>

#include "server/merge/alignment_book.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

/// Sessions 1 and 2 have ended after 61 m and were looked at; others come as a test says.
class AwaitedPath : public testing::Test {
 protected:
  void SetUp() override {
    for (const SessionId id : {1, 2}) add_ended(id);
  }
  void add_ended(SessionId id) {
    grow(id, 61);
    sessions_.complete(id);
    sessions_.set_looked_at(id, true);
  }
  void grow(SessionId id, int metres) {
    sessions_.add(id, {"test", 1});
    for (int m = 0; m <= metres; ++m) add_metre(id, m);
  }
  void add_metre(SessionId id, int m) {
    Keyframe k = line_keyframe(static_cast<std::uint64_t>(m) + 1);
    k.stamp_s = m;
    sessions_.add_keyframe(id, k);
  }
  double awaited_m(double similar_places, double probability = 0.99) const {
    Evidence evidence;
    evidence.probability = probability;
    evidence.similar_places = similar_places;
    evidence.overlap_m = 3;
    return sessions_.path_awaited_m({1, 2}, Pose::Identity(), evidence);
  }

  static MergeConfig with_short_paths() {
    MergeConfig config;
    config.least_path_m = 0;
    return config;
  }
  const MergeConfig config_ = with_short_paths();
  SessionMap sessions_{config_};
};

TEST_F(AwaitedPath, IsLongerTheMorePlacesLookAlikeAndTheLessSureItIs) {
  add_metre(2, 62);  // it drives on after all
  const double alone_m = awaited_m(0);
  EXPECT_NEAR(alone_m, config_.shown_m - 3, 0.01);
  EXPECT_NEAR(awaited_m(1) - alone_m, config_.shown_more_m, 1e-9);
  EXPECT_NEAR(awaited_m(4) - alone_m, 4 * config_.shown_more_m, 1e-9);
  EXPECT_EQ(awaited_m(5), awaited_m(4)) << "a bound";
  EXPECT_NEAR(awaited_m(0, 0.98), alone_m, 1e-6);
  const double one_less = 1 / (1 + std::exp(1) * 0.02 / 0.98);  // by a unit of log-odds
  EXPECT_NEAR(awaited_m(0, one_less) - alone_m, config_.shown_doubt_m, 1e-6);
  EXPECT_NEAR(awaited_m(0, 0.5) - alone_m, 2 * config_.shown_doubt_m, 1e-6) << "a bound";
}

// A few metres of tile fit many places, and a robot that stops there may be anywhere.
TEST_F(AwaitedPath, OfAShortSessionThatHasEndedIsMoreTheMoreLooksAlikeAndTheLessSureItIs) {
  for (const int metres : {10, 19, 20, 21, 35, 49, 50}) {
    const SessionId id = 100 + SessionId{metres};
    grow(id, metres);
    sessions_.complete(id);
    const auto awaited_m = [&](double similar_places, double probability) {
      Evidence evidence;
      evidence.similar_places = similar_places;
      evidence.probability = probability;
      evidence.overlap_m = metres;
      return sessions_.path_awaited_m({1, id}, Pose::Identity(), evidence);
    };
    const auto least = [&](double asked_m) { return std::max(0.0, asked_m - metres); };
    EXPECT_NEAR(awaited_m(0, 0.99), least(SessionMap::short_m), 1e-6) << metres;
    EXPECT_NEAR(awaited_m(1, 0.99), least(SessionMap::short_m + config_.shown_more_m), 1e-6) << metres;
    EXPECT_NEAR(awaited_m(0, 0.5), least(SessionMap::most_of_short_m), 1e-6) << metres << " m, and a bound";
  }
}

TEST_F(AwaitedPath, OfOneWhoAsksWhereItIsIsLongerInAMineThatLooksLikeItself) {
  grow(3, 40);
  const auto awaited_m = [&](double of_mine, double overlap_m) {
    Evidence evidence;
    evidence.probability = 0.99;
    evidence.mine_look_alikes = of_mine;
    evidence.overlap_m = overlap_m;
    return sessions_.path_awaited_to_localize_m(3, {1, 3}, Pose::Identity(), evidence);
  };
  EXPECT_EQ(awaited_m(0, 20), 0);
  EXPECT_EQ(awaited_m(0.1, 20), 0) << "no more than chance";
  EXPECT_NEAR(awaited_m(0.2, 20), 10, 1e-6);
  EXPECT_NEAR(awaited_m(0.3, 20), 40, 1e-6);
  EXPECT_NEAR(awaited_m(3, 20), 40, 1e-6) << "a bound";
  EXPECT_NEAR(awaited_m(3, 50), 10, 1e-6) << "a copy of 50 m";
  EXPECT_EQ(awaited_m(3, 60), 0);
}

TEST_F(AwaitedPath, OfOthersCountsWherePlacesLookAlikeAlone) {
  sessions_.add(4, {"test", 1});  // stands at the portal: it has told nothing yet
  grow(3, 20);
  EXPECT_EQ(awaited_m(config_.look_alikes - 0.01), 0);
  EXPECT_NEAR(awaited_m(config_.look_alikes), config_.shown_m + config_.look_alikes * config_.shown_more_m - 20, 0.01);
  sessions_.complete(3);
  EXPECT_EQ(awaited_m(2), 1) << "it has ended, and nobody has looked what it says";
  sessions_.set_looked_at(3, true);
  EXPECT_EQ(awaited_m(2), 0);
}

TEST_F(AwaitedPath, OfOthersHasAnEnd) {
  grow(3, static_cast<int>(config_.shown_m + 2 * config_.shown_more_m));
  EXPECT_EQ(awaited_m(2), 0) << "a robot that drives for hours holds nobody up";
}

TEST_F(AwaitedPath, OfOthersIsOfThoseAloneThatDrive) {
  const auto add_on_the_spot = [&](std::uint64_t sequence) {
    Keyframe k = line_keyframe(sequence);
    k.T_local_sensor.translation().x() = 11;
    k.stamp_s = static_cast<double>(sequence);
    sessions_.add_keyframe(3, k);
  };
  grow(3, 10);
  EXPECT_NEAR(awaited_m(2), config_.shown_m + 2 * config_.shown_more_m - 10, 1e-6);
  for (std::uint64_t i = 12; i <= 40 + 12; ++i) add_on_the_spot(i);
  EXPECT_GT(awaited_m(2), 0) << "40 keyframes over 10 m, and a turn on the spot";
  add_on_the_spot(53);
  EXPECT_EQ(awaited_m(2), 0) << "it floods a spot with keyframes";
}

TEST_F(AwaitedPath, OfOthersIsNothingOnceTheyWereAwaitedLongEnough) {
  grow(3, 20);
  EXPECT_GT(awaited_m(2), 0);
  sessions_.await_no_more(3);
  add_metre(3, 21);
  EXPECT_EQ(awaited_m(2), 0);
}

TEST_F(AwaitedPath, WhatWaitedForOthersIsToldWhenTheyHaveEnded) {
  grow(3, 20);
  AlignmentBook book(config_, sessions_);
  AttemptReport report;
  Judgement judged;
  judged.T_a_b = pose_from_yaw(0.5, {1, 2, 0});
  judged.evidence.probability = 0.99;
  judged.evidence.inlier_fraction = 1;
  judged.evidence.similar_places = 3;
  book.record({1, 2}, judged, std::nullopt, false, report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::candidate) << "85 m are awaited";
  sessions_.complete(3);
  book.release_awaited(report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::candidate) << "it was not looked at";
  sessions_.set_looked_at(3, true);
  report = {};
  book.release_awaited(report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::verified);
  ASSERT_EQ(report.changed.size(), 1U);
  EXPECT_EQ(report.changed[0].verdict, AlignmentState::verified);
}

TEST_F(AwaitedPath, WhatWasRefusedOnceWaitsForTheOperatorToo) {
  AlignmentBook book(config_, sessions_);
  AttemptReport report;
  Judgement judged;
  judged.evidence.probability = 0.99;
  judged.evidence.inlier_fraction = 1;
  judged.evidence.seen_points = 1000;
  book.record({1, 2}, judged, std::nullopt, false, report);
  ASSERT_TRUE(book.decide(book.find(1, 2)->id, Decision::refuse, report));
  grow(3, 20);
  judged.evidence.seen_points = 10000;  // so much more that it is proposed again
  judged.evidence.similar_places = 3;
  book.record({1, 2}, judged, std::nullopt, false, report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::rejected) << "what was ruled on stays in sight";
  sessions_.complete(3);
  sessions_.set_looked_at(3, true);
  book.record({1, 2}, judged, std::nullopt, false, report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::candidate);
  book.release_awaited(report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::candidate);
}

TEST_F(AwaitedPath, IsToldAsProvisionalWhereNothingLooksAlike) {
  add_metre(2, 62);
  const auto state_with = [&](double similar_places, double missing_m, double probability = 0.99) {
    AlignmentBook book(config_, sessions_);
    AttemptReport report;
    Judgement judged;
    judged.evidence.probability = probability;
    judged.evidence.similar_places = similar_places;
    judged.evidence.overlap_m = config_.shown_m + config_.shown_more_m * similar_places - missing_m;
    book.record({1, 2}, judged, std::nullopt, false, report);
    return book.find(1, 2)->state;
  };
  EXPECT_EQ(state_with(0, config_.provisional_m), AlignmentState::provisional);
  EXPECT_EQ(state_with(0, config_.provisional_m + 1), AlignmentState::candidate);
  EXPECT_EQ(state_with(config_.look_alikes - 0.1, 1), AlignmentState::provisional);
  EXPECT_EQ(state_with(config_.look_alikes, 1), AlignmentState::candidate);
  EXPECT_EQ(state_with(0, 1, config_.provisional_probability), AlignmentState::provisional);
  EXPECT_EQ(state_with(0, 1, config_.provisional_probability - 0.001), AlignmentState::candidate);
}

TEST_F(AwaitedPath, WhatWaitsForCloudsTooIsJudgedAnewAndNotReleased) {
  grow(3, 20);
  AlignmentBook book(config_, sessions_);
  AttemptReport report;
  Judgement judged;
  judged.evidence.probability = 0.99;
  judged.evidence.similar_places = 3;
  book.record({1, 2}, judged, std::nullopt, true, report);
  sessions_.complete(3);
  sessions_.set_looked_at(3, true);
  book.release_awaited(report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::candidate);
  book.record({1, 2}, judged, std::nullopt, false, report);
  EXPECT_EQ(book.find(1, 2)->state, AlignmentState::verified);
}

// Two tiles that look alike, and the clouds of the right one come a second later than those of the copy.
TEST_F(AwaitedPath, NothingIsToldThatContradictsWhatWaitsForClouds) {
  add_ended(3);
  Contact met = Contact::contradicts;
  const auto contacts = [&](SessionId a, SessionId b, const Pose&) { return a == 2 && b == 3 ? met : Contact::none; };
  const auto state_beside = [&](AlignmentState other, double similar_places) {
    AlignmentBook book(config_, sessions_);
    AttemptReport report;
    Judgement judged;
    judged.evidence.inlier_fraction = 1;
    judged.evidence.overlap_m = 30;
    judged.evidence.similar_places = similar_places;
    judged.evidence.probability = 0.98;
    book.record({1, 2}, judged, std::nullopt, false, report);
    judged.evidence.probability = other == AlignmentState::rejected ? 0.01 : 0.82;
    book.record({1, 3}, judged, std::nullopt, other == AlignmentState::candidate, report);
    book.update_atlas(
        contacts, [](const auto&) { return Objection(); }, report);
    return book.find(1, 2)->state;
  };
  EXPECT_EQ(state_beside(AlignmentState::candidate, 3), AlignmentState::verified) << "held back";
  EXPECT_EQ(state_beside(AlignmentState::rejected, 3), AlignmentState::published);
  EXPECT_EQ(state_beside(AlignmentState::candidate, config_.look_alikes - 0.1), AlignmentState::published)
      << "where little looks alike";
  met = Contact::unknown;
  EXPECT_EQ(state_beside(AlignmentState::candidate, 3), AlignmentState::verified)
      << "held back until somebody has looked";
  met = Contact::agrees;
  EXPECT_EQ(state_beside(AlignmentState::candidate, 3), AlignmentState::published);
}

// A copy of the place that a third session fits nearly as well: as long as that one is a candidate, neither is told.
TEST_F(AwaitedPath, ACopyIsNotToldWhileACandidateContradictsItThatWaitsForNothing) {
  add_ended(3);
  Contact met = Contact::contradicts;
  const auto contacts = [&](SessionId a, SessionId b, const Pose&) { return a == 2 && b == 3 ? met : Contact::none; };
  AlignmentBook book(config_, sessions_);
  AttemptReport report;
  Judgement judged;
  judged.evidence.inlier_fraction = 1;
  judged.evidence.overlap_m = 30;
  judged.evidence.similar_places = 3;
  judged.evidence.probability = 0.95;
  book.record({1, 2}, judged, std::nullopt, false, report);
  judged.evidence.probability = 0.8;
  book.record({1, 3}, judged, std::nullopt, false, report);
  ASSERT_EQ(book.find(1, 3)->state, AlignmentState::candidate);
  const auto state = [&] {
    book.update_atlas(
        contacts,
        [](const auto& pair) {
          return Objection{pair.first, pair.second, 0.03};
        },
        report);
    return book.find(1, 2)->state;
  };
  EXPECT_EQ(state(), AlignmentState::verified);
  ASSERT_TRUE(book.find(1, 2)->objection);
  EXPECT_EQ(book.find(1, 2)->objection->a, 2);
  EXPECT_EQ(book.find(1, 2)->objection->b, 3);
  met = Contact::unknown;
  EXPECT_EQ(state(), AlignmentState::verified) << "until somebody has looked";
  EXPECT_FALSE(book.find(1, 2)->objection);
  met = Contact::none;
  EXPECT_EQ(state(), AlignmentState::published);
  met = Contact::contradicts;
  EXPECT_EQ(state(), AlignmentState::verified) << "it is taken back";
}

}  // namespace
}  // namespace headframe
