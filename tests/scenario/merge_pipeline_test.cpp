// Drawn mines through the whole pipeline, without sockets or disk: what must merge does, what must not does not.

#include "server/merge/merge_pipeline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::Base;
using test::BoxMine;
using test::Drive;

// The mine and the drives: tests/support/drawn_session.hpp.
Drive a() { return test::drive_a_to_c(3); }
Drive b() { return test::drive_b_to_a(3); }
Drive c() { return test::drive_d_to_b(3); }

TEST(MergePipeline, ThreeDrivesBecomeOneComponentWhicheverIsTriedFirst) {
  for (const SessionId first : {1, 2, 3}) {
    Base base({a(), b(), c()});
    EXPECT_EQ(base.pipeline.attempt(first, base.shelf).wanted.size(), 0U);
    for (const SessionId id : {1, 2, 3}) base.pipeline.attempt(id, base.shelf);
    ASSERT_EQ(base.pipeline.atlas().components.size(), 1U) << "first " << first;
    EXPECT_LT(base.error_m(), 0.15) << "first " << first;
  }
}

TEST(MergePipeline, TheOrderOfArrivalDoesNotMatter) {
  std::vector<std::size_t> order{0, 1, 2};
  std::vector<Pose> first;  // of the second and third drive in the first's frame
  do {
    const std::vector<Drive> drives{a(), b(), c()};
    Base base({});
    for (const std::size_t i : order) base.pipeline.attempt(base.arrive(drives[i]), base.shelf);
    ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
    EXPECT_LT(base.error_m(), 0.15);
    std::vector<Pose> T_component(3);
    for (const Placement& p : base.pipeline.atlas().components[0].placements)
      T_component[order[static_cast<std::size_t>(p.session - 1)]] = p.T_component_session;
    std::vector<Pose> now{T_component[0].inverse() * T_component[1], T_component[0].inverse() * T_component[2]};
    if (first.empty()) first = now;
    for (std::size_t i = 0; i < now.size(); ++i) {
      EXPECT_LT((now[i].translation() - first[i].translation()).norm(), 0.15);
      EXPECT_LT(rotation_angle_rad(now[i].inverse() * first[i]), 0.005);
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(MergePipeline, LookAlikeDriftsDoNotMerge) {
  // Two mines of equal drifts and equal crossings; the second goes on where the first ends, so they can not be one.
  const BoxMine one({BoxMine::drift(0, 0, 90, 0), BoxMine::drift(45, 0, 45, 40)});
  const BoxMine two({BoxMine::drift(0, 0, 90, 0), BoxMine::drift(45, 0, 45, 18), BoxMine::drift(20, -30, 20, 0)});
  Base base({test::drive(one, {{2, 0}, {88, 0}}, 0, 1), test::drive(two, {{2, 0}, {88, 0}}, 1.0, 2)});
  base.pipeline.attempt(1, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
  EXPECT_EQ(base.pipeline.atlas().revision, 0U);
}

/// The most placements that were judged for a pair of the session that came to nothing, with so many partners at least.
std::size_t most_judged_in_vain(int partners, Pose& T_merged) {
  MergeConfig config = test::waits_for_no_others();
  config.partners = partners;
  std::vector<Drive> drives{a()};
  for (unsigned i = 1; i <= 4; ++i) {
    const double n = i;
    const BoxMine other({BoxMine::drift(0, 0, 70, 0), BoxMine::drift(10 + 12 * n, 0, 10 + 12 * n, 12 + n)});
    drives.push_back(test::drive(other, {{2, 0}, {68, 0}}, 0.1 * n, i));
  }
  drives.push_back(b());
  Base base(drives, config);
  std::size_t most = 0;
  for (bool more = true; more;) {
    const AttemptReport report = base.pipeline.attempt(6, base.shelf);
    for (const PairTrace& trace : report.traces)
      if (trace.a != 1) most = std::max(most, trace.judged.size());
    more = report.unfinished;
  }
  EXPECT_EQ(base.pipeline.atlas().components.size(), 5U);
  for (const Alignment& k : base.pipeline.alignments())
    if (k.a == 1 && k.b == 6 && k.state == AlignmentState::published) T_merged = k.T_a_b;
  return most;
}

TEST(MergePipeline, OfManyPartnersTheLikeliestPlacementsDecideWhetherOthersAreLookedAt) {
  Pose T_few = Pose::Identity(), T_many = Pose::Identity();
  EXPECT_LT(most_judged_in_vain(4, T_many), most_judged_in_vain(16, T_few));
  EXPECT_FALSE(T_few.isApprox(Pose::Identity()));
  EXPECT_TRUE(T_few.isApprox(T_many, 1e-12)) << "the merge is the same";
}

TEST(MergePipeline, AStraightDriftAloneProvesNothing) {
  const BoxMine mine({BoxMine::drift(0, 0, 300, 0)});
  Base base({test::drive(mine, {{60, 0}, {140, 0}}, 0, 1), test::drive(mine, {{200, 0}, {120, 0}}, 1.0, 2)});
  base.pipeline.attempt(1, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
}

TEST(MergePipeline, AsksForTheCloudsItNeedsAndThenMerges) {
  Base base({a(), b()});
  for (const auto& [ref, cloud] : base.shelf.clouds) base.shelf.on_robots.insert(ref);
  std::set<KeyframeRef> asked;
  for (int round = 0; round < 10; ++round) {
    const AttemptReport report = base.pipeline.attempt(1, base.shelf);
    if (report.wanted.empty()) break;
    for (const KeyframeRef& ref : report.wanted) {
      asked.insert(ref);
      base.shelf.on_robots.erase(ref);
    }
  }
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_GT(asked.size(), 0U);
}

TEST(MergePipeline, AShortSessionThatStillGrowsWaits) {
  const auto path_m = [](const Drive& d) { return 3.0 * static_cast<double>(d.keyframes.size() - 1); };
  Drive shortened = a();
  while (path_m(shortened) >= MergeConfig{}.least_path_m) shortened.keyframes.pop_back();
  MergeConfig config = test::waits_for_no_others();
  config.shown_m = 0;
  Base base({b()}, config);
  const SessionId growing = base.grow(shortened);
  base.pipeline.attempt(growing, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
  EXPECT_TRUE(base.pipeline.alignments().empty()) << "nothing that were found would be told: it is not looked for";
  base.pipeline.complete_session(growing);
  base.pipeline.attempt(growing, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
}

/// What became of b, still driving, beside the drive to the other branch, which has ended.
Alignment while_b_drives(double shown_m) {
  MergeConfig config = test::waits_for_no_others();
  config.shown_m = shown_m;
  config.shown_more_m = config.shown_doubt_m = config.provisional_probability = 0;
  Base base({a()}, config);
  base.pipeline.attempt(base.grow(b()), base.shelf);
  return base.pipeline.alignments().at(0);
}

TEST(MergePipeline, WhatARobotHasYetToSeeMayContradictSoItDrivesOnBeforeItIsTold) {
  const Alignment waits = while_b_drives(1000);
  EXPECT_EQ(waits.state, AlignmentState::candidate);
  EXPECT_TRUE(convinces(waits.evidence, {}));
  const double shown_m = 1000 - waits.evidence.awaited_m;
  EXPECT_NEAR(shown_m, waits.evidence.overlap_m, 3) << "b has just come from where they met";
  EXPECT_EQ(while_b_drives(shown_m - 0.1).state, AlignmentState::published);
  EXPECT_EQ(while_b_drives(shown_m + 0.1).state, AlignmentState::provisional);
  const double told_m = shown_m + MergeConfig{}.provisional_m;
  EXPECT_EQ(while_b_drives(told_m - 0.1).state, AlignmentState::provisional);
  EXPECT_EQ(while_b_drives(told_m + 0.1).state, AlignmentState::candidate);
}

TEST(MergePipeline, WhatIsProvisionalStandsBesideTheAtlasUntilItIsTold) {
  MergeConfig config = test::waits_for_no_others();
  config.shown_m = 1000;
  config.provisional_m = 2000;
  config.provisional_probability = 0;
  Base base({a()}, config);
  const SessionId growing = base.grow(b());
  const AttemptReport report = base.pipeline.attempt(growing, base.shelf);
  EXPECT_TRUE(report.provisional_changed);
  EXPECT_FALSE(report.atlas_changed);
  EXPECT_EQ(base.pipeline.atlas().revision, 0U);
  const std::vector<Component> parts = base.pipeline.atlas().components;
  ASSERT_EQ(parts.size(), 2U);
  const Pose T_1_2 = base.drive(1).T_mine_local.inverse() * base.drive(2).T_mine_local;
  for (const Component& part : parts) {
    ASSERT_EQ(part.provisional.size(), 1U);
    const ProvisionalPlacement& placed = part.provisional[0];
    EXPECT_EQ(placed.session, 3 - part.id);
    const Pose T_part_other = part.id == 1 ? T_1_2 : T_1_2.inverse();
    EXPECT_LT((placed.T_component_session.translation() - T_part_other.translation()).norm(), 0.15);
    EXPECT_GT(placed.probability, 0.9);
    EXPECT_GT(placed.awaited_m, 900);
  }
  EXPECT_FALSE(base.pipeline.attempt(growing, base.shelf).provisional_changed) << "nothing new";
  base.pipeline.complete_session(growing);
  EXPECT_TRUE(base.pipeline.attempt(growing, base.shelf).provisional_changed) << "it is told now";
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_TRUE(base.pipeline.atlas().components[0].provisional.empty());
}

TEST(MergePipeline, WhatWaitedIsToldWhenTheRobotEndsAndStandsWhenItDrivesOnAfterAll) {
  MergeConfig config = test::waits_for_no_others();
  config.shown_m = 1000;
  Drive first = b();
  const Keyframe last = first.keyframes.back();
  first.keyframes.pop_back();
  Base base({a()}, config);
  const SessionId growing = base.grow(first);
  base.pipeline.attempt(growing, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
  base.pipeline.complete_session(growing);
  base.pipeline.attempt(growing, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  base.pipeline.add_keyframe(growing, last);
  base.pipeline.attempt(growing, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
}

TEST(MergePipeline, RestoresWhatItHad) {
  Base base({a(), b()});
  const AttemptReport report = base.pipeline.attempt(2, base.shelf);
  EXPECT_TRUE(report.atlas_changed);
  EXPECT_EQ(base.pipeline.atlas().revision, 1U);
  Base later({a(), b()});
  later.pipeline.restore(base.pipeline.alignments(), base.pipeline.atlas().revision);
  EXPECT_EQ(later.pipeline.atlas().revision, 1U);
  ASSERT_EQ(later.pipeline.atlas().components.size(), 1U);
  EXPECT_FALSE(later.pipeline.attempt(1, later.shelf).atlas_changed) << "nothing new, no new revision";
}

TEST(MergePipeline, ASessionThatIsSetAsideLeavesTheOthersAndComesBack) {
  Base base({a(), b(), c()});
  for (const SessionId id : {1, 2, 3}) base.pipeline.attempt(id, base.shelf);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  const AttemptReport report = base.pipeline.set_aside(3);
  EXPECT_TRUE(report.atlas_changed);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(base.pipeline.atlas().components[0].placements.size(), 2U);
  EXPECT_TRUE(base.pipeline.attempt(3, base.shelf).changed.empty());
  base.pipeline.attempt(1, base.shelf);
  base.pipeline.add_session(3, ScanContext().id());
  for (const Keyframe& keyframe : base.drive(3).keyframes) base.pipeline.add_keyframe(3, keyframe);
  base.pipeline.complete_session(3);
  base.pipeline.attempt(3, base.shelf);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(base.pipeline.atlas().components[0].placements.size(), 3U);
  EXPECT_LT(base.error_m(), 0.15);
}

TEST(MergePipeline, ARetractedMergeStaysOutUntilItIsUndone) {
  Base base({a(), b()});
  base.pipeline.attempt(2, base.shelf);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  const auto retracted = base.pipeline.decide(1, Decision::retract);
  ASSERT_TRUE(retracted);
  EXPECT_TRUE(retracted->atlas_changed);
  EXPECT_EQ(base.pipeline.atlas().revision, 2U);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
  base.pipeline.attempt(1, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U) << "the same placement on the same evidence";
  EXPECT_EQ(base.pipeline.alignments().at(0).state, AlignmentState::retracted);
  ASSERT_TRUE(base.pipeline.decide(1, Decision::undo));
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(base.pipeline.atlas().revision, 3U);
  EXPECT_LT(base.error_m(), 0.15);
  EXPECT_FALSE(base.pipeline.decide(1, Decision::undo));
  EXPECT_EQ(base.pipeline.decide(9, Decision::confirm).error().code, ErrorCode::not_found);
}

TEST(MergePipeline, AConfirmedCandidateIsPublishedAndKeptByLaterAttempts) {
  MergeConfig strict;
  strict.accept_probability = 1.1;  // nothing is published by itself
  Base base({a(), b()}, strict);
  base.pipeline.attempt(2, base.shelf);
  ASSERT_EQ(base.pipeline.alignments().at(0).state, AlignmentState::candidate);
  ASSERT_TRUE(base.pipeline.decide(1, Decision::confirm));
  EXPECT_EQ(base.pipeline.alignments().at(0).state, AlignmentState::published);
  base.pipeline.attempt(1, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(base.pipeline.alignments().at(0).ruling, Ruling::confirmed);
  ASSERT_TRUE(base.pipeline.decide(1, Decision::undo));
  EXPECT_EQ(base.pipeline.alignments().at(0).state, AlignmentState::candidate);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
}

TEST(MergePipeline, DecisionsSurviveARestart) {
  Base base({a(), b()});
  base.pipeline.attempt(2, base.shelf);
  const auto report = base.pipeline.decide(1, Decision::retract);
  ASSERT_TRUE(report);
  Base later({a(), b()});
  later.pipeline.restore(base.pipeline.alignments(), base.pipeline.atlas().revision, report->decided);
  EXPECT_EQ(later.pipeline.alignments().at(0).ruling, Ruling::retracted);
  later.pipeline.attempt(1, later.shelf);
  EXPECT_EQ(later.pipeline.atlas().components.size(), 2U);
  ASSERT_TRUE(later.pipeline.decide(1, Decision::undo));
  EXPECT_EQ(later.pipeline.atlas().components.size(), 1U);
}

/// As a robot with vectors of its own making sends it.
Drive with_descriptor(Drive drive, const Descriptor& descriptor) {
  for (Keyframe& keyframe : drive.keyframes) keyframe.descriptor = descriptor;
  return drive;
}

TEST(MergePipeline, SessionsOfAFamilyThatNobodyKnowsMeetByTheirWalls) {
  Base base({});
  base.arrive(with_descriptor(a(), {{1, 2}, {}}), {"of its own", 7});
  base.pipeline.attempt(base.arrive(with_descriptor(b(), {{1, 2}, {}}), {"of its own", 7}), base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_LT(base.error_m(), 0.15);
}

TEST(MergePipeline, VectorsOfOtherLengthsUnderOneNameDoNoHarm) {
  Base base({});
  base.arrive(with_descriptor(a(), {{1}, {1, 2}}), {"of its own", 7});
  base.arrive(with_descriptor(b(), {std::vector<float>(4096, 1), {1, 2, 3}}), {"of its own", 7});
  base.arrive(with_descriptor(c(), {{1, 2}, {}}), {"of its own", 7});
  for (const SessionId id : {1, 2, 3}) base.pipeline.attempt(id, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U) << "the walls agree";
}

TEST(MergePipeline, SessionsOfAnotherFamilyOrVersionMergeByTheirWalls) {
  Drive turned_round = b();  // numbers that would speak against every placement, were they compared
  for (Keyframe& k : turned_round.keyframes) std::reverse(k.descriptor.q.begin(), k.descriptor.q.end());
  for (const FamilyId& other : {FamilyId{"scan_context", 2}, FamilyId{"lidar_iris", 1}}) {
    Base base({a()});
    base.pipeline.attempt(base.arrive(turned_round, other), base.shelf);
    EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
    EXPECT_LT(base.error_m(), 0.15);
    ASSERT_EQ(base.pipeline.alignments().size(), 1U);
    EXPECT_EQ(base.pipeline.alignments().front().evidence.descriptors_compared, 0);
  }
}

TEST(MergePipeline, GarbageKeyframesChangeNothing) {
  Base base({a(), b()});
  std::mt19937 rng(1);
  Keyframe garbage;
  garbage.sequence = base.drives[1].keyframes.size() + 1;
  garbage.T_local_sensor = base.drives[1].keyframes.back().T_local_sensor;
  for (auto& code : garbage.walls.code) code = static_cast<std::uint8_t>(rng());
  for (int i = 0; i < 60; ++i) garbage.descriptor.q.push_back(static_cast<float>(rng() % 10));
  garbage.descriptor.w = garbage.descriptor.q;
  garbage.point_count = 1;
  base.pipeline.add_keyframe(2, garbage);
  base.pipeline.complete_session(2);
  base.pipeline.attempt(2, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_LT(base.error_m(), 0.15);
}

}  // namespace
}  // namespace headframe
