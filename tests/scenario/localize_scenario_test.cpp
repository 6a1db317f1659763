// Robots that wake up in drawn mines and ask where they are.
#include <gtest/gtest.h>

#include "server/merge/session_map.hpp"
#include "tests/scenario/drawn_base.hpp"
#include "tests/scenario/drawn_copies.hpp"
#include "tests/support/branched_mine.hpp"

namespace headframe {
namespace {

using test::Base;
using test::BoxMine;
using test::Drive;

/// What the robot of a drive is told after each two metres, from a start without any past.
std::vector<SessionLocalization> told_along(Base& base, const Drive& drive) {
  std::vector<SessionLocalization> told;
  base.drives.push_back(drive);
  const auto id = static_cast<SessionId>(base.drives.size());
  base.pipeline.add_session(id, ScanContext().id());
  EXPECT_TRUE(base.pipeline.ask_where(id, true));
  for (std::size_t k = 0; k < drive.keyframes.size(); ++k) {
    base.shelf.clouds[{id, k + 1}] = drive.clouds[k];
    base.pipeline.add_keyframe(id, drive.keyframes[k]);
    base.pipeline.attempt(id, base.shelf);
    told.push_back(base.pipeline.localization(id));
  }
  return told;
}

double error_m(const Base& base, const Drive& woken, const SessionLocalization& l) {
  const Pose truth = base.drive(l.component).T_mine_local.inverse() * woken.T_mine_local *
                     woken.keyframes[l.keyframe - 1].T_local_sensor;
  return (truth.translation() - l.T_component_sensor.translation()).norm();
}

TEST(LocalizeScenario, ARobotThatWakesUpInAMappedMineIsToldWhereItIs) {
  Base base({test::drive_that_maps()});
  const Drive woken = test::drive_that_wakes_up();
  const auto told = told_along(base, woken);
  ASSERT_TRUE(told.back().found) << told.back().missing << ", p " << told.back().probability;
  EXPECT_FALSE(told.back().merged);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 2U) << "nothing is merged for the question";
  for (const SessionLocalization& l : told) {
    if (l.found) {
      EXPECT_LT(error_m(base, woken, l), 0.5) << "at keyframe " << l.keyframe;
      EXPECT_GE(4 * static_cast<double>(l.keyframe - 1), SessionMap::localize_m - 4)
          << "not before it has shown enough";
    } else {
      EXPECT_NE(l.missing, "");
    }
  }
}

TEST(LocalizeScenario, WithoutTheQuestionAShortSessionIsNotLookedAt) {
  Base base({test::drive_that_maps()});
  const SessionId id = base.grow(test::drive_that_wakes_up(4, 40));
  base.pipeline.attempt(id, base.shelf);
  EXPECT_TRUE(base.pipeline.alignments().empty());
}

TEST(LocalizeScenario, InRockThatNobodyMappedNothingIsTold) {
  Base base({test::drive_that_maps()});
  for (const SessionLocalization& l : told_along(base, test::drive_elsewhere()))
    EXPECT_FALSE(l.found) << "keyframe " << l.keyframe;
}

TEST(LocalizeScenario, AmongCopiesNothingIsTold) {
  Base base({test::drive_through_copies()});
  const BoxMine copies = test::with_copies({BoxMine::drift(0, 0, 200, 0)}, 5);
  for (const SessionLocalization& l : told_along(base, drive(copies, {{62, 0}, {98, 0}}, 1, 5, 6)))
    EXPECT_FALSE(l.found) << "keyframe " << l.keyframe;
}

TEST(LocalizeScenario, WhatItIsToldDoesNotHangOnWhenItAsked) {
  const Drive map = test::drive_that_maps(), woken = test::drive_that_wakes_up();
  Base early({map}), late({map});
  const SessionLocalization each_time = told_along(early, woken).back();
  const SessionId id = late.grow(woken);
  late.pipeline.ask_where(id, true);
  late.pipeline.attempt(id, late.shelf);
  const SessionLocalization at_the_end = late.pipeline.localization(id);
  EXPECT_EQ(at_the_end.found, each_time.found);
  EXPECT_LT((at_the_end.T_component_sensor.translation() - each_time.T_component_sensor.translation()).norm(), 0.1);
}

}  // namespace
}  // namespace headframe
