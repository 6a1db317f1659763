// Robots that send a cloud only when it is asked for: what is asked, when, and what is believed meanwhile.

#include <gtest/gtest.h>

#include "server/verification/submap.hpp"
#include "tests/scenario/drawn_base.hpp"
#include "tests/scenario/drawn_copies.hpp"

namespace headframe {
namespace {

using test::Base;
using test::BoxMine;
using test::Drive;

/// So few that the first look leaves a doubt.
constexpr std::size_t a_few = 1;
MergeConfig config() {
  MergeConfig out = test::waits_for_no_others();
  out.clouds_requested = a_few;
  return out;
}

struct OnRequest : Base {
  explicit OnRequest(const std::vector<Drive>& all, const std::set<SessionId>& on_robots) : Base(all, config()) {
    for (const auto& [ref, cloud] : shelf.clouds)
      if (on_robots.contains(ref.session)) shelf.on_robots.insert(ref);
    while (pipeline.prepare_ahead(shelf)) {
    }
  }
  void send(const std::vector<KeyframeRef>& wanted) {
    for (const KeyframeRef& ref : wanted) sent += shelf.on_robots.erase(ref);
  }
  /// Attempts for the second session until nothing more is wanted. each: what to look at in between.
  template <class Each>
  void send_all(Each&& each) {
    for (auto report = pipeline.attempt(2, shelf); !report.wanted.empty(); report = pipeline.attempt(2, shelf)) {
      each(report);
      const std::size_t before = sent;
      send(report.wanted);
      ASSERT_GT(sent, before) << "asks for what it has";
    }
  }
  void send_all() {
    send_all([](const auto&) {});
  }
  void lose_the_robots() {
    for (const KeyframeRef& ref : shelf.on_robots) shelf.clouds.erase(ref);
    shelf.on_robots.clear();
  }
  /// Of the first two sessions; null: not tried yet.
  const Alignment* pair() const {
    const auto& all = pipeline.alignments();
    const auto found = std::find_if(all.begin(), all.end(), [](const Alignment& k) { return k.a == 1 && k.b == 2; });
    return found == all.end() ? nullptr : &*found;
  }
  Eigen::Vector3d in_mine(const KeyframeRef& ref) const {
    return drive(ref.session).T_mine_local *
           drive(ref.session).keyframes[ref.sequence - 1].T_local_sensor.translation();
  }

  std::size_t sent = 0;
};

/// Sixty metres of drift with branches, driven by both; each goes on where the other was not.
const BoxMine& long_mine() {
  static const BoxMine mine({BoxMine::drift(0, 0, 220, 0), BoxMine::drift(85, 0, 85, 14),
                             BoxMine::drift(112, -9, 112, 0, 6), BoxMine::drift(136, 0, 136, 20)});
  return mine;
}
Drive west() { return test::drive(long_mine(), {{2, 0}, {140, 0}}, 0, 1); }
Drive east() { return test::drive(long_mine(), {{218, 0}, {80, 0}}, 1.1, 2); }

TEST(CloudsOnRequest, AFirstLookTakesAFewOfEachAroundOneSpot) {
  OnRequest base({west(), east()}, {1, 2});
  const auto report = base.pipeline.attempt(2, base.shelf);
  std::map<SessionId, std::size_t> asked;
  for (const KeyframeRef& ref : report.wanted) {
    ++asked[ref.session];
    EXPECT_LT((base.in_mine(ref) - base.in_mine(report.wanted.front())).norm(), 2 * SubmapConfig{}.radius_m);
  }
  EXPECT_EQ(asked, (std::map<SessionId, std::size_t>{{1, a_few}, {2, a_few}}));
}

TEST(CloudsOnRequest, WhatIsInDoubtAsksForMoreOfTheOverlapUntilItIsTold) {
  OnRequest base({west(), east()}, {1, 2});
  bool doubted = false;
  base.send_all([&](const AttemptReport&) {
    if (!base.pair()) return;
    doubted |= base.pair()->state == AlignmentState::candidate;
  });
  EXPECT_TRUE(doubted);
  EXPECT_EQ(base.pair()->state, AlignmentState::published);
  EXPECT_LT(base.error_m(), 0.15);
  EXPECT_LT(base.sent, base.shelf.clouds.size()) << "not the whole maps";
}

TEST(CloudsOnRequest, AMergeIsSettledWhereItLiesWithAllClouds) {
  OnRequest base({west(), east()}, {1, 2}), all({west(), east()}, {});
  base.send_all();
  for (int i = 0; i < 3; ++i) all.pipeline.attempt(2, all.shelf);
  ASSERT_EQ(base.pair()->state, AlignmentState::published);
  ASSERT_EQ(all.pair()->state, AlignmentState::published);
  const Eigen::Vector3d p = position(base.drive(2).keyframes.back());
  EXPECT_LT((base.pair()->T_a_b * p - all.pair()->T_a_b * p).norm(), 0.05);
  EXPECT_LT(base.sent, base.shelf.clouds.size());
}

TEST(CloudsOnRequest, WhatSettlesAMergeIsAskedWhoeverIsTriedNext) {
  OnRequest base({west(), east(), test::drive_b_to_a(3)}, {});
  base.pipeline.attempt(2, base.shelf);
  ASSERT_EQ(base.pair()->state, AlignmentState::published);
  for (const auto& [ref, cloud] : base.shelf.clouds)  // as if the end of the overlap had never come
    if (ref.session == 1 && base.in_mine(ref).x() > 115) base.shelf.on_robots.insert(ref);
  const std::size_t held = base.shelf.on_robots.size();
  const std::vector<KeyframeRef> wanted = base.pipeline.attempt(3, base.shelf).wanted;
  const std::set<KeyframeRef> asked(wanted.begin(), wanted.end());
  ASSERT_FALSE(asked.empty());
  for (const KeyframeRef& ref : asked) EXPECT_TRUE(base.shelf.on_robots.contains(ref));
  EXPECT_LT(asked.size(), held) << "one at each place";
  base.send(wanted);
  EXPECT_TRUE(base.pipeline.attempt(3, base.shelf).wanted.empty()) << "that is all";
}

TEST(CloudsOnRequest, ADoubtThatNobodyCanLiftIsNotMerged) {
  OnRequest base({west(), east()}, {1, 2});
  std::vector<KeyframeRef> wanted = base.pipeline.attempt(2, base.shelf).wanted;
  wanted.resize(wanted.size() / 2);
  base.send(wanted);
  base.lose_the_robots();
  EXPECT_TRUE(base.pipeline.attempt(2, base.shelf).wanted.empty());
  EXPECT_LT(base.pair()->evidence.probability, MergeConfig{}.accept_probability);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
}

TEST(CloudsOnRequest, ThoseWhoShareNothingDoNotSendAll) {
  OnRequest base({test::along_copies(100, 0, 5), test::drive_b_to_a(3)}, {1, 2});
  base.send_all();
  EXPECT_EQ(base.pair()->state, AlignmentState::rejected);
  EXPECT_LT(base.sent, base.shelf.clouds.size());
}

/// Three blocks that are the same, and what is like nothing else.
BoxMine half_copies() {
  return test::with_copies({BoxMine::drift(0, 0, 220, 0), BoxMine::drift(150, 0, 150, 16),
                            BoxMine::drift(171, -11, 171, 0, 6), BoxMine::drift(196, 0, 196, 24)},
                           3);
}

TEST(CloudsOnRequest, BeforeAMergeIsBelievedBothAreAskedWhetherTheirMineRepeatsItself) {
  OnRequest base(
      {test::drive(half_copies(), {{2, 0}, {200, 0}}, 0, 1), test::drive(half_copies(), {{218, 0}, {145, 0}}, 1.1, 2)},
      {1, 2});
  base.send_all();
  ASSERT_TRUE(base.pair());
  std::size_t of_the_copies = 0;  // clouds of where the two do not meet
  for (const auto& [ref, cloud] : base.shelf.clouds)
    of_the_copies += ref.session == 1 && !base.shelf.on_robots.contains(ref) && base.in_mine(ref).x() < 120;
  EXPECT_GT(of_the_copies, 0U);
}

TEST(CloudsOnRequest, InAMineOfCopiesTheLookFartherOffIsWaitedFor) {
  OnRequest base({test::along_copies(103, 0, 5), test::along_copies(140, 1.1, 6), test::drive_through_copies()},
                 {1, 2});
  bool waited = false;
  base.send_all([&](const AttemptReport&) {
    if (!base.pair()) return;
    EXPECT_NE(base.pair()->state, AlignmentState::published);
    waited |= base.pair()->evidence.probability >= MergeConfig{}.accept_probability;
  });
  EXPECT_TRUE(waited);
  EXPECT_LT(base.pair()->evidence.probability, MergeConfig{}.accept_probability);
  EXPECT_GE(base.pair()->evidence.farther_violation, 0.003);
}

}  // namespace
}  // namespace headframe
