// A mine that is worked on between drives: right merges hold, and what changed is listed where it is.

#include <gtest/gtest.h>

#include <algorithm>

#include "server/atlas/change_list.hpp"
#include "tests/bench/pipeline_run.hpp"
#include "tests/support/changed_mine.hpp"

namespace headframe {
namespace {

using bench::DrivenSession;
using bench::PipelineRun;
using test::drive_at;
using test::Work;
using test::worked_mine;

constexpr double first_day_s = 1.7e9, day_s = 86400, month_s = 30 * day_s;

struct Scene {
  const char* name;
  Work work;
  ChangeKind kind;
  std::vector<std::size_t> before, after, third_before, third_after;  // nodes of the drives
};

void PrintTo(const Scene& scene, std::ostream* out) { *out << scene.name; }

const Scene scenes[] = {
    {"AnAdvancedFace", Work::advanced_face, ChangeKind::excavated, {0, 1, 2, 3}, {3, 2, 1, 4}, {4, 1, 2, 3}, {5, 2, 3}},
    {"ASlashedWall", Work::slashed_wall, ChangeKind::excavated, {0, 1, 2, 3}, {4, 1, 2, 5}, {3, 2, 1, 4}, {5, 2, 1, 0}},
    {"AParkedMachine",
     Work::parked_machine,
     ChangeKind::filled,
     {0, 1, 2, 3},
     {4, 1, 2, 5},
     {3, 2, 1, 4},
     {5, 2, 1, 0}},
    {"ABackfilledStope",
     Work::backfilled_stope,
     ChangeKind::filled,
     {4, 1, 2, 3},
     {0, 1, 2, 5},
     {3, 2, 1, 4},
     {5, 2, 1, 0}},
    {"AVentilationDoor",
     Work::ventilation_door,
     ChangeKind::filled,
     {0, 1, 2, 5},
     {3, 2, 1, 4},
     {5, 2, 1, 4},
     {0, 1, 2, 3}},
};

const mine::World& old_mine() {
  static const mine::World world = mine::build_world({worked_mine(Work::nothing)});
  return world;
}

Alignment between(const PipelineRun& run, SessionId a, SessionId b) {
  const auto& all = run.pipeline.alignments();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Alignment& k) { return k.a == a && k.b == b; });
  return found == all.end() ? Alignment{} : *found;
}

class ChangeScenes : public testing::TestWithParam<Scene> {};

TEST_P(ChangeScenes, ARightMergeHoldsAndTheChangeIsListed) {
  const Scene& scene = GetParam();
  const mine::World new_mine = mine::build_world({worked_mine(scene.work)});
  const DrivenSession before = drive_at(old_mine(), "before", scene.before, first_day_s),
                      after = drive_at(new_mine, "after", scene.after, first_day_s + month_s),
                      third_before = drive_at(old_mine(), "third before", scene.third_before, first_day_s + day_s),
                      third_after = drive_at(new_mine, "third after", scene.third_after, first_day_s + month_s + day_s);
  PipelineRun run;
  run.add(before);
  run.add(after);
  run.attempt(2);
  ASSERT_TRUE(judge_outcome(run, 1, 2).right) << between(run, 1, 2).evidence.probability;
  const Alignment merged = between(run, 1, 2);
  EXPECT_GT(merged.evidence.freespace_explained, 0);
  EXPECT_LE(merged.evidence.freespace_explained, merged.evidence.freespace_violation + 1e-12)
      << "no more than there is";
  const auto changes = changes_since(0, {&merged}, run.pipeline.atlas());
  ASSERT_EQ(changes.size(), 1U);
  const Pose T_mine_component = before.path.T_world_sensor[0] * before.path.T_local_sensor[0].inverse();
  const Eigen::Vector3d p = T_mine_component * changes[0].p;
  EXPECT_LT((p - test::place_of(scene.work)).head<2>().norm(), 1) << p.transpose();
  EXPECT_EQ(changes[0].change.kind, scene.kind);
  EXPECT_EQ(changes[0].older, 1);
  EXPECT_EQ(changes[0].newer, 2);
  EXPECT_LT(changes[0].change.older_s, first_day_s + 1000);
  EXPECT_GE(changes[0].change.newer_s, first_day_s + month_s);
  for (const DrivenSession* third : {&third_before, &third_after}) {
    run.attempt(run.add(*third));
    EXPECT_TRUE(judge_outcome(run, 1, 2).right) << "a session from " << third->name << " retracts nothing";
    EXPECT_EQ(run.pipeline.atlas().components.size(), 1U) << third->name;
  }
}

INSTANTIATE_TEST_SUITE_P(Changes, ChangeScenes, testing::ValuesIn(scenes),
                         [](const auto& scene) { return std::string(scene.param.name); });

/// The two drives of the advanced face with so much between them; stamps count from first_s.
Alignment face_after(double gap_s, double first_s = first_day_s) {
  const mine::World new_mine = mine::build_world({worked_mine(Work::advanced_face)});
  const DrivenSession before = drive_at(old_mine(), "before", scenes[0].before, first_s);
  const double ends_s = before.keyframes.back().stamp_s;
  const DrivenSession after = drive_at(new_mine, "after", scenes[0].after, ends_s + gap_s);
  PipelineRun run;
  run.add(before);
  run.add(after);
  run.attempt(2);
  return between(run, 1, 2);
}

TEST(Changes, SessionsOfTheSameHourHaveNoExcuse) {
  const Alignment same_hour = face_after(least_gap_s - 120);  // a submap holds keyframes from a way around it
  EXPECT_NE(same_hour.state, AlignmentState::published);
  EXPECT_TRUE(same_hour.changes.empty());
  EXPECT_EQ(same_hour.evidence.freespace_explained, 0);
  EXPECT_EQ(face_after(least_gap_s + 1).state, AlignmentState::published);
}

TEST(Changes, RobotsWithoutADateHaveNoExcuse) {
  const Alignment undated = face_after(month_s, 12);
  EXPECT_NE(undated.state, AlignmentState::published);
  EXPECT_TRUE(undated.changes.empty());
}

TEST(Changes, AnExactCopyThatEndsElsewhereIsNotTakenForTheSameMineAMonthLater) {
  const mine::World copy = mine::build_world({worked_mine(Work::elsewhere)});
  for (const double gap_s : {0.0, month_s}) {
    PipelineRun run;
    const DrivenSession one = drive_at(old_mine(), "one", {0, 1, 2, 3}, first_day_s),
                        other = drive_at(copy, "other", {3, 2, 1, 4}, first_day_s + gap_s);
    run.add(one);
    run.add(other);
    run.attempt(2);
    EXPECT_NE(between(run, 1, 2).state, AlignmentState::published) << gap_s;
    EXPECT_EQ(between(run, 1, 2).evidence.worst_place_explained, 0) << gap_s;
  }
}

}  // namespace
}  // namespace headframe
