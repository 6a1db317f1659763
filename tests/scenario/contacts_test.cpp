// Three sessions: what the third knows of the mine decides on a merge of the other two.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/scenario/drawn_base.hpp"
#include "tests/scenario/drawn_copies.hpp"

namespace headframe {
namespace {

using test::along_copies;
using test::Base;
using test::Box;
using test::BoxMine;
using test::Drive;
using test::drive_through_copies;

/*  70                      +          Two mines, the same but for the east end: there one goes on to the north, the
 *                          |  (one)   other to the south.
 *  30        +-----+-------+
 *            |     |       |  (two)
 *  12   |    |    18       |
 *   0 --+----+             |
 *       15   30    42      60                                                                          */
BoxMine mine(bool north) {
  return BoxMine({BoxMine::drift(0, 0, 30, 0), BoxMine::drift(15, 0, 15, 12), BoxMine::drift(30, 0, 30, 30),
                  BoxMine::drift(30, 30, 60, 30), BoxMine::drift(42, 30, 42, 18),
                  north ? BoxMine::drift(60, 30, 60, 70) : BoxMine::drift(60, 30, 60, -10)});
}

Drive of_one() { return test::drive(mine(true), {{2, 0}, {30, 0}, {30, 30}, {44, 30}}, 0, 1); }
/// Of two merges that can not both be right this one has less to show: it shares three keyframes.
Drive of_two() { return test::drive(mine(false), {{30, 20}, {30, 30}, {60, 30}, {60, -8}}, 1.2, 2, 8); }
Drive witness() { return test::drive(mine(true), {{60, 68}, {60, 30}, {30, 30}, {30, 0}, {4, 0}}, -0.4, 3); }

const Alignment& between(const Base& base, SessionId a, SessionId b) {
  const auto& all = base.pipeline.alignments();
  return *std::find_if(all.begin(), all.end(), [&](const Alignment& k) { return k.a == a && k.b == b; });
}

void attempt_all(Base& base) {
  for (std::size_t id = 1; id <= base.drives.size(); ++id)
    base.pipeline.attempt(static_cast<SessionId>(id), base.shelf);
}

TEST(Contacts, TwoMinesThatAreTheSameWhereTwoRobotsMetCanNotBeToldApartByThemAlone) {
  Base base({of_one(), of_two()});
  attempt_all(base);
  EXPECT_EQ(between(base, 1, 2).state, AlignmentState::published) << "what the tests below rest on";
}

/// The robots that met where two mines are the same have ended; one that knows better is still on its way there.
/// Whether the two were together at any moment, and at the end.
std::pair<bool, bool> together_while_the_witness_drives(const MergeConfig& config) {
  Base base({of_one(), of_two()}, config);
  const auto together = [&] { return between(base, 1, 2).state == AlignmentState::published; };
  base.drives.push_back(witness());
  base.pipeline.add_session(3, ScanContext().id());
  bool ever = false;
  for (std::size_t k = 0; k < base.drive(3).keyframes.size(); ++k) {
    base.pipeline.add_keyframe(3, base.drive(3).keyframes[k]);
    base.shelf.clouds[{3, k + 1}] = base.drive(3).clouds[k];
    if (k % 4 != 0) continue;
    attempt_all(base);
    ever |= together();
  }
  base.pipeline.complete_session(3);
  attempt_all(base);
  return {ever, together()};
}

TEST(Contacts, AWrongMergeIsNotToldWhileARobotDrivesThatMayContradictIt) {
  EXPECT_EQ(together_while_the_witness_drives(test::waits_for_no_others()), (std::pair{true, false}))
      << "what the test rests on";
  EXPECT_EQ(together_while_the_witness_drives({}), (std::pair{false, false}));
}

TEST(Contacts, AThirdSessionFullOfCopiesAsksForALongerOverlap) {
  Base base({of_one(), of_two(), drive_through_copies()});
  while (base.pipeline.prepare_ahead(base.shelf)) {
  }
  attempt_all(base);
  const Alignment& short_one = between(base, 1, 2);
  EXPECT_GT(short_one.evidence.repetition, 0.3);
  EXPECT_LT(short_one.evidence.probability, MergeConfig{}.accept_probability);
  EXPECT_GE(short_one.evidence.probability_if_unique, MergeConfig{}.accept_probability);
}

TEST(Contacts, WhatWouldBeBelievedIsLookedAtFartherOff) {
  for (const bool copies : {false, true}) {
    Base base({along_copies(100, 0, 5), along_copies(130, 1.1, 6)});
    if (copies) base.arrive(drive_through_copies());
    while (base.pipeline.prepare_ahead(base.shelf)) {
    }
    attempt_all(base);
    const Alignment& k = between(base, 1, 2);
    EXPECT_EQ(k.evidence.repetition >= copies_known, copies);
    EXPECT_GE(k.evidence.farther_violation, 0.003);
    EXPECT_LT(k.evidence.probability, MergeConfig{}.accept_probability);
    EXPECT_NE(k.state, AlignmentState::published);
  }
  Base same({along_copies(100, 0, 5), along_copies(100, 1.1, 6), drive_through_copies()});
  while (same.pipeline.prepare_ahead(same.shelf)) {
  }
  attempt_all(same);
  EXPECT_EQ(between(same, 1, 2).state, AlignmentState::published) << "one mine";
}

TEST(Contacts, PathsThatNeverMeetAreLookedAtFartherOffWhereTheyComeNearest) {
  const auto farther_violation = [](double end_m) {
    Base base({along_copies(99, 0, 5, 8, -3), along_copies(end_m, 1.1, 6, 8, 3)});
    attempt_all(base);
    return between(base, 1, 2).evidence.farther_violation;
  };
  EXPECT_LT(farther_violation(99), 0.0003) << "one mine";
  EXPECT_GT(farther_violation(130), 0.001) << "two paths, 6 m apart";
}

/// 180 m with branches that differ, all of it, with odometry that makes paths too long by this share.
Drive stretched(double share, double yaw_rad, unsigned seed) {
  std::vector<Box> drifts{BoxMine::drift(0, 0, 180, 0)};
  for (const auto& [x, y, width] : {std::array{15.0, 14.0, 4.0},
                                    {32.0, -9.0, 6.0},
                                    {47.0, 20.0, 4.0},
                                    {61.0, -16.0, 3.0},
                                    {74.0, 9.0, 7.0},
                                    {88.0, 14.0, 3.0},
                                    {101.0, -12.0, 5.0},
                                    {119.0, 18.0, 4.0},
                                    {131.0, -7.0, 8.0},
                                    {150.0, 12.0, 3.0},
                                    {168.0, -18.0, 5.0}})
    drifts.push_back(BoxMine::drift(x, std::min(y, 0.0), x, std::max(y, 0.0), width));
  Drive out = test::drive(BoxMine(drifts), {{2, 0}, {178, 0}}, yaw_rad, seed);
  for (Keyframe& k : out.keyframes) k.T_local_sensor.translation() *= 1 + share;
  return out;
}

TEST(Contacts, WhatOdometryStretchedIsNoContradictionFartherOff) {
  Base base({stretched(0, 0, 5), stretched(0.025, 1.1, 6)});
  attempt_all(base);
  const Alignment& k = between(base, 1, 2);
  EXPECT_LT(k.evidence.farther_violation, 0.001) << "the ends are 2.2 m off where the middle is right";
  EXPECT_EQ(k.state, AlignmentState::published);
}

TEST(Contacts, AThirdSessionThatContradictsHoldsTheMergeBack) {
  Base base({of_one(), of_two(), witness()});
  attempt_all(base);
  EXPECT_EQ(between(base, 1, 3).state, AlignmentState::published);
  const Alignment& wrong = between(base, 1, 2);
  EXPECT_EQ(wrong.state, AlignmentState::verified);
  ASSERT_TRUE(wrong.objection);
  EXPECT_EQ(std::pair(wrong.objection->a, wrong.objection->b), (std::pair<SessionId, SessionId>(2, 3)));
  EXPECT_GT(wrong.objection->violation, 0.015);
  EXPECT_LT(wrong.objection->violation, 1);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U);
  int attempts = 0;
  while (base.pipeline.attempt(1, base.shelf).unfinished)
    ASSERT_LT(++attempts, 10) << "what is held back waits quietly";
}

TEST(Contacts, AThirdSessionThatComesLaterTakesAPublishedMergeBack) {
  Base base({of_one(), of_two()});
  attempt_all(base);
  const auto revision = base.pipeline.atlas().revision;
  const AttemptReport report = base.pipeline.attempt(base.arrive(witness()), base.shelf);
  EXPECT_EQ(between(base, 1, 2).state, AlignmentState::retracted);
  EXPECT_EQ(between(base, 1, 3).state, AlignmentState::published);
  EXPECT_GT(base.pipeline.atlas().revision, revision);
  EXPECT_TRUE(std::any_of(report.changed.begin(), report.changed.end(), [](const Alignment& k) {
    return k.a == 1 && k.b == 2 && k.state == AlignmentState::retracted;
  })) << "it is stored and told";
}

TEST(Contacts, AfterARestartAMergeThatWasHeldBackStaysSo) {
  Base before({of_one(), of_two(), witness()}), after({of_one(), of_two(), witness()});
  attempt_all(before);
  after.pipeline.restore(before.pipeline.alignments(), before.pipeline.atlas().revision);
  EXPECT_EQ(between(after, 1, 2).state, AlignmentState::verified) << "though nobody has looked again yet";
  EXPECT_EQ(after.pipeline.atlas().components.size(), 2U);
  attempt_all(after);
  EXPECT_EQ(between(after, 1, 2).state, AlignmentState::verified);
  EXPECT_TRUE(between(after, 1, 2).objection);
}

TEST(Contacts, AfterARestartAMergeWaitsForASessionThatWasNotTriedYet) {
  Base before({of_one(), of_two()}, {});
  before.grow(test::drive(mine(true), {{60, 68}, {60, 50}}, -0.4, 3));
  attempt_all(before);
  ASSERT_GT(between(before, 1, 2).evidence.awaited_m, 0) << "for the third, which drives on";
  const Drive elsewhere = test::drive(BoxMine({BoxMine::drift(0, 0, 9, 0)}), {{1, 0}, {6, 0}}, 0, 4);
  for (const bool awaits : {false, true}) {
    Base after({of_one(), of_two(), witness(), elsewhere}, {});
    after.pipeline.restore(before.pipeline.alignments(), before.pipeline.atlas().revision);
    if (awaits) after.pipeline.await_attempt(3);
    const AttemptReport report = after.pipeline.attempt(4, after.shelf);
    EXPECT_EQ(between(after, 1, 2).state == AlignmentState::published, !awaits) << "what is wrong is told without it";
    attempt_all(after);
    EXPECT_NE(between(after, 1, 2).state, AlignmentState::published);
  }
}

/// The third says nothing of itself where it shares the drift with the first: only the second can place it.
std::vector<Drive> third_by_way_of_second(double from_x_m) {
  Drive third = test::drive(test::branches_mine(), {{from_x_m, 0}, {88, 0}}, 0.6, 4);
  for (Keyframe& k : third.keyframes)
    if (k.T_local_sensor.translation().norm() < 46 - from_x_m) k.walls = {}, k.descriptor = {};
  return {test::drive_a_to_c(3), test::drive_b_to_a(3), third};
}

TEST(Contacts, SessionsThatMeetByWayOfAnotherAreAlignedWhereTheyMeet) {
  Base base(third_by_way_of_second(6));
  attempt_all(base);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(between(base, 1, 3).state, AlignmentState::published);
  EXPECT_EQ(between(base, 1, 3).evidence.support, 0) << "no search proposed it";
  EXPECT_LT(base.error_m(), 0.15);
}

TEST(Contacts, WhatTheyRecordedStandsInAMineThatTurnsOutToRepeatItself) {
  Base base(third_by_way_of_second(12));
  const KeyframeRef late{3, 3};  // where the first and the third meet
  const KeyframeCloud cloud = base.shelf.clouds.extract(late).mapped();
  attempt_all(base);
  ASSERT_EQ(between(base, 1, 3).state, AlignmentState::published);
  base.arrive(drive_through_copies());
  while (base.pipeline.prepare_ahead(base.shelf)) {
  }
  base.shelf.clouds[late] = cloud;
  attempt_all(base);
  EXPECT_EQ(between(base, 1, 3).state, AlignmentState::published);
  const AttemptReport again = base.pipeline.attempt(3, base.shelf);
  EXPECT_TRUE(again.changed.empty());
  EXPECT_FALSE(again.unfinished) << "or it would be tried again without end";
}

}  // namespace
}  // namespace headframe
