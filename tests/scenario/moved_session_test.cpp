// Robots whose SLAM moves the past, in drawn mines.
#include <gtest/gtest.h>

#include <numeric>

#include "server/session/same_placement.hpp"
#include "tests/scenario/drawn_base.hpp"
#include "tests/support/branched_mine.hpp"

namespace headframe {
namespace {

using test::Base;
using test::Drive;

/// As odometry has it that turns a little with each step, and is too long by 1 %.
Drive drifted(Drive drive, double rad_per_m) {
  std::vector<Pose> straight;
  for (const Keyframe& k : drive.keyframes) straight.push_back(k.T_local_sensor);
  for (std::size_t i = 1; i < straight.size(); ++i) {
    Pose step = straight[i - 1].inverse() * straight[i];
    const double m = step.translation().norm();
    step.translation() *= 1.01;
    drive.keyframes[i].T_local_sensor =
        orthonormalised(drive.keyframes[i - 1].T_local_sensor * pose_from_yaw(rad_per_m * m, {0, 0, 0}) * step);
  }
  return drive;
}

/// Session 1 maps the tunnel's one half. Session 2 comes from its other end, and where the two meet it has drifted.
Drive half() { return test::drive(test::branched_mine(), {{2, 0}, {72, 0}}, 0.7, 4, 2); }
Drive comes_from_the_end() { return test::drive(test::branched_mine(), {{108, 0}, {26, 0}}, -2, 9, 2); }
constexpr double drift_rad_per_m = 0.001;

struct TwoDrives : Base {
  const Drive truth = comes_from_the_end();
  TwoDrives() : Base({half(), drifted(comes_from_the_end(), drift_rad_per_m)}) { try_all(); }

  void try_all() {
    for (int round = 0; round < 3; ++round)
      for (SessionId id = 1; id <= static_cast<SessionId>(drives.size()); ++id)
        for (int i = 0; i < 20 && pipeline.attempt(id, shelf).unfinished; ++i) {
        }
  }
  bool merged() const { return pipeline.atlas().components.size() == 1; }
  Pose T_1_2() const {
    const auto& component = pipeline.atlas().components.at(0);
    return placement_in(component, 1)->T_component_session.inverse() * placement_in(component, 2)->T_component_session;
  }
  Pose T_1_2_true() const { return drives[0].T_mine_local.inverse() * truth.T_mine_local; }
  /// How far keyframes from `first` on lie off, at the poses that the session has.
  std::vector<double> off_m(const Drive& as_it_is, std::size_t first = 0) const {
    std::vector<double> all;
    for (std::size_t i = first; i < truth.keyframes.size(); ++i)
      all.push_back((T_1_2() * position(as_it_is.keyframes[i]) - T_1_2_true() * position(truth.keyframes[i])).norm());
    return all;
  }
  AttemptReport move(const Drive& to) { return pipeline.move_session(2, to.keyframes); }
};

double worst(const std::vector<double>& all) { return *std::max_element(all.begin(), all.end()); }
double mean(const std::vector<double>& all) {
  return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
}

TEST(MovedSession, AMergeThatIsJudgedAgainAndStandsWhereItStoodLeavesNothingToDo) {
  TwoDrives base;
  ASSERT_TRUE(base.merged());
  Drive nearly_the_same = base.drives[1];
  nearly_the_same.keyframes.back().T_local_sensor.translation().x() += 1e-3;
  base.move(nearly_the_same);  // the pair is judged again as a whole
  const AttemptReport report = base.pipeline.attempt(2, base.shelf);
  EXPECT_FALSE(report.traces.empty()) << "it was judged";
  EXPECT_FALSE(report.unfinished) << "or this would be done again without end";
}

TEST(MovedSession, AClosedLoopPullsItStraightAndWhereTheyMeetItStays) {
  TwoDrives base;
  ASSERT_TRUE(base.merged());
  const Drive bent = base.drives[1];
  constexpr std::size_t from_there = 22;  // 18 m and more into the half that both saw
  const double before_m = mean(base.off_m(bent));
  ASSERT_GT(before_m, 0.4) << "it drifts";
  ASSERT_GT((position(bent.keyframes.back()) - position(base.truth.keyframes.back())).norm(), 1.5);
  const std::uint64_t revision = base.pipeline.atlas().revision;

  const AttemptReport report = base.move(base.truth);
  EXPECT_TRUE(report.atlas_changed);
  EXPECT_GT(base.pipeline.atlas().revision, revision);
  ASSERT_TRUE(base.merged()) << "it stands until it is judged anew";
  ASSERT_EQ(report.changed.size(), 1U) << "and is stored where it lies now";
  EXPECT_EQ(report.changed[0].state, AlignmentState::published);
  EXPECT_TRUE(report.changed[0].T_a_b.isApprox(base.pipeline.alignments().at(0).T_a_b));
  EXPECT_LT(mean(base.off_m(base.truth, from_there)), 0.3) << "at once";

  base.try_all();
  ASSERT_TRUE(base.merged());
  EXPECT_LT(worst(base.off_m(base.truth, from_there)), 0.3);
  const double after_m = mean(base.off_m(base.truth));
  EXPECT_LT(after_m, before_m / 2);
  RecordProperty("mean_error_before_m", std::to_string(before_m));
  RecordProperty("mean_error_after_m", std::to_string(after_m));
  EXPECT_EQ(base.pipeline.alignments().at(0).state, AlignmentState::published);
  EXPECT_GT(base.pipeline.alignments().at(0).evidence.path_m, 100) << "judged as a whole";
}

TEST(MovedSession, ItIsAsIfItHadComeSo) {
  TwoDrives base;
  ASSERT_TRUE(base.merged());
  base.move(base.truth);
  base.try_all();
  Base other({half(), comes_from_the_end()});
  for (int i = 0; i < 20; ++i)
    for (const SessionId id : {1, 2}) other.pipeline.attempt(id, other.shelf);
  ASSERT_EQ(other.pipeline.atlas().components.size(), 1U);
  const Pose T = placement_in(other.pipeline.atlas().components[0], 2)->T_component_session;
  EXPECT_TRUE(same_placement(T, base.T_1_2(), position(base.truth.keyframes.back()), {0.05, 0.01}));
}

TEST(MovedSession, AnUpdateThatMovesNothingChangesNothing) {
  TwoDrives base;
  ASSERT_TRUE(base.merged());
  const Atlas before = base.pipeline.atlas();
  Drive same = base.drives[1];
  for (Keyframe& k : same.keyframes) k.T_local_sensor.linear() = Eigen::Quaterniond(k.T_local_sensor.linear()).matrix();
  const AttemptReport report = base.move(same);
  EXPECT_FALSE(report.atlas_changed);
  EXPECT_TRUE(report.changed.empty());
  EXPECT_EQ(base.pipeline.atlas().revision, before.revision);
  EXPECT_TRUE(base.T_1_2().matrix() == before.components[0].placements[1].T_component_session.matrix());
}

TEST(MovedSession, AFrameThatIsAnotherAltogetherTakesThePlacementAlong) {
  TwoDrives base;
  ASSERT_TRUE(base.merged());
  const Pose T_before = base.T_1_2(), T_new_old = pose_from_yaw(1.1, {700, -2600, 3});  // in whole kilometres another
  Drive elsewhere = base.drives[1];
  for (Keyframe& k : elsewhere.keyframes) k.T_local_sensor = T_new_old * k.T_local_sensor;
  EXPECT_TRUE(base.move(elsewhere).atlas_changed);
  ASSERT_TRUE(base.merged());
  EXPECT_TRUE(same_placement(base.T_1_2() * T_new_old, T_before, {0, 0, 0}, {1e-6, 1e-6}));
  base.try_all();
  ASSERT_TRUE(base.merged());
  EXPECT_TRUE(same_placement(base.T_1_2() * T_new_old, T_before, position(base.truth.keyframes.back()), {0.05, 0.01}));
}

TEST(MovedSession, AMergeThatTheNewPosesDoNotSupportIsGivenUp) {
  TwoDrives base;
  ASSERT_TRUE(base.merged());
  Drive nonsense = base.drives[1];
  for (std::size_t i = 1; i < nonsense.keyframes.size(); ++i) {
    nonsense.keyframes[i].T_local_sensor =
        base.drives[1].keyframes[i - 1].T_local_sensor.inverse() * base.drives[1].keyframes[i].T_local_sensor;
    nonsense.keyframes[i].T_local_sensor.translation() *= 1.8;
    nonsense.keyframes[i].T_local_sensor =
        orthonormalised(nonsense.keyframes[i - 1].T_local_sensor * pose_from_yaw(0.09, {0, 0, 0}) *
                        nonsense.keyframes[i].T_local_sensor);
  }
  base.move(nonsense);
  base.try_all();
  EXPECT_FALSE(base.merged());
  base.move(base.truth);
  base.try_all();
  EXPECT_TRUE(base.merged()) << "and made again once it is";
}

TEST(MovedSession, AFrozenOneAndOneThatIsNotHereStay) {
  TwoDrives base;
  ASSERT_TRUE(base.pipeline.freeze(2));
  const std::uint64_t revision = base.pipeline.atlas().revision;
  EXPECT_FALSE(base.move(base.truth).atlas_changed);
  EXPECT_FALSE(base.pipeline.move_session(9, base.truth.keyframes).atlas_changed);
  EXPECT_EQ(base.pipeline.atlas().revision, revision);
  ASSERT_TRUE(base.pipeline.thaw(2));
  EXPECT_TRUE(base.move(base.truth).atlas_changed);
}

TEST(MovedSession, WhatTheOperatorRefusedStaysRefusedWhereItLiesNow) {
  TwoDrives base;
  const AlignmentId id = base.pipeline.alignments().at(0).id;
  ASSERT_TRUE(base.pipeline.decide(id, Decision::retract));
  ASSERT_FALSE(base.merged());
  const AttemptReport report = base.move(base.truth);
  ASSERT_EQ(report.decided.size(), 1U);
  EXPECT_TRUE(
      same_placement(report.decided[0].T_a_b, base.T_1_2_true(), position(base.truth.keyframes.back()), {0.5, 0.05}));
  base.try_all();
  EXPECT_FALSE(base.merged());
}

}  // namespace
}  // namespace headframe
