// Two mines in one database: drives that overlap, told to be of two sites, in drawn mines.
#include <gtest/gtest.h>

#include "server/merge/session_map.hpp"
#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::Base;

/// Sessions 1 and 2 overlap; they are of different sites unless it is said otherwise.
struct TwoSites : Base {
  explicit TwoSites(const std::string& site_of_second = "south") : Base({}) {
    arrive_at("north", test::drive_a_to_c(1));
    arrive_at(site_of_second, test::drive_b_to_a(1));
  }
  SessionId arrive_at(const std::string& site, const test::Drive& drive) {
    pipeline.add_session(static_cast<SessionId>(drives.size()) + 1, ScanContext().id(), site);
    return arrive(drive);
  }
  void attempt_all() {
    for (SessionId id = 1; id <= static_cast<SessionId>(drives.size()); ++id) pipeline.attempt(id, shelf);
  }
  std::size_t components() const { return pipeline.atlas().components.size(); }
};

TEST(Sites, SessionsOfTwoAreNeverTried) {
  TwoSites base;
  base.attempt_all();
  EXPECT_EQ(base.components(), 2U);
  EXPECT_TRUE(base.pipeline.alignments().empty());
  TwoSites one("north");
  one.attempt_all();
  EXPECT_EQ(one.components(), 1U) << "of one site they merge";
}

TEST(Sites, ASessionThatIsTakenToAnotherMergesThereAndNoLongerWhereItWas) {
  TwoSites base;
  base.arrive_at("north", test::drive_a_to_c(5));
  base.attempt_all();
  ASSERT_EQ(base.components(), 2U) << "1 and 3";
  AttemptReport report = base.pipeline.set_site(3, "south");
  EXPECT_TRUE(report.atlas_changed);
  ASSERT_EQ(report.changed.size(), 1U);
  EXPECT_EQ(report.changed[0].state, AlignmentState::rejected);
  EXPECT_EQ(base.components(), 3U);
  base.attempt_all();
  ASSERT_EQ(base.components(), 2U) << "2 and 3";
  EXPECT_TRUE(placement_in(base.pipeline.atlas().components[1], 3));
  report = base.pipeline.set_site(3, "north");
  EXPECT_EQ(base.components(), 2U) << "what was known there counts again, before anything is tried";
  EXPECT_TRUE(placement_in(base.pipeline.atlas().components[0], 3));
  base.attempt_all();
  EXPECT_EQ(base.components(), 2U);
  base.pipeline.set_site(2, "north");
  base.attempt_all();
  EXPECT_EQ(base.components(), 1U);
  EXPECT_LT(base.error_m(), 0.3);
  EXPECT_FALSE(base.pipeline.set_site(3, "north").atlas_changed) << "it is there already";
  EXPECT_FALSE(base.pipeline.set_site(9, "north").atlas_changed) << "there is no such session";
}

TEST(Sites, WhatIsStillToBeSettledOfAMergeIsNotLookedAtOnceASessionWasTakenAway) {
  TwoSites base;
  base.arrive_at("north", test::drive_a_to_c(5));
  base.pipeline.attempt(3, base.shelf);
  ASSERT_EQ(base.components(), 2U) << "1 and 3";
  base.pipeline.set_site(3, "east");
  base.pipeline.attempt(2, base.shelf);
  EXPECT_EQ(base.components(), 3U);
  EXPECT_EQ(base.pipeline.alignments().at(0).state, AlignmentState::rejected);
}

TEST(Sites, WhatAnOperatorMergedAcrossThemBringsNoOthersTogether) {
  TwoSites base;
  base.arrive_at("north", test::drive_a_to_c(5));
  AttemptReport report;
  const Pose T_1_2 = base.drive(1).T_mine_local.inverse() * base.drive(2).T_mine_local;
  ASSERT_TRUE(base.pipeline.place(1, 2, T_1_2, base.shelf, report));
  const AlignmentId by_hand = base.pipeline.alignments().at(0).id;
  ASSERT_TRUE(base.pipeline.decide(by_hand, Decision::confirm));
  for (int i = 0; i < 3; ++i) base.attempt_all();
  ASSERT_EQ(base.components(), 1U) << "2, and 1 with 3";
  ASSERT_TRUE(base.pipeline.decide(by_hand, Decision::retract));
  base.attempt_all();
  EXPECT_EQ(base.components(), 2U) << "nothing else held 2 there";
}

TEST(Sites, AnOperatorMayMergeAcrossThem) {
  TwoSites base;
  AttemptReport report;
  const Pose T_1_2 = base.drive(1).T_mine_local.inverse() * base.drive(2).T_mine_local;
  const auto placed = base.pipeline.place(1, 2, T_1_2, base.shelf, report);
  ASSERT_TRUE(placed) << placed.error().message;
  base.attempt_all();
  EXPECT_EQ(base.components(), 2U) << "a candidate until it is confirmed";
  ASSERT_TRUE(base.pipeline.decide(base.pipeline.alignments().at(0).id, Decision::confirm));
  base.attempt_all();
  EXPECT_EQ(base.components(), 1U);
  TwoSites merged("north");
  merged.attempt_all();
  ASSERT_TRUE(merged.pipeline.decide(merged.pipeline.alignments().at(0).id, Decision::confirm));
  merged.pipeline.set_site(2, "south");
  EXPECT_EQ(merged.components(), 1U) << "what he confirmed stays";
}

TEST(Sites, NobodyWaitsForThoseWhoDriveAtAnother) {
  MergeConfig config;
  SessionMap sessions(config);
  for (const SessionId id : {1, 2, 3}) {
    sessions.add(id, ScanContext().id(), id == 3 ? "south" : "north");
    for (int i = 0; i < (id == 3 ? 5 : 200); ++i) {
      Keyframe k;
      k.sequence = static_cast<std::uint64_t>(i) + 1;
      k.stamp_s = i;
      k.T_local_sensor.translation().x() = i;
      sessions.add_keyframe(id, k);
    }
    if (id != 3) sessions.complete(id), sessions.set_looked_at(id, true);
  }
  Evidence evidence;
  evidence.overlap_m = 60;
  evidence.probability = 0.99;
  evidence.similar_places = 8;
  EXPECT_EQ(sessions.path_awaited_m({1, 2}, Pose::Identity(), evidence), 0);
  sessions.set_site(3, "north");
  EXPECT_GT(sessions.path_awaited_m({1, 2}, Pose::Identity(), evidence), 5) << "it drives there";
}

}  // namespace
}  // namespace headframe
