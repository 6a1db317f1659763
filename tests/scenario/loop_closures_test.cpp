// Where drives through drawn mines meet again: what the pose graph learns from it.

#include <gtest/gtest.h>

#include <cmath>

#include "server/merge/corrected_poses.hpp"
#include "server/merge/loop_closures.hpp"
#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::Base;
using test::BoxMine;

using Closures = std::map<std::pair<SessionId, SessionId>, std::vector<PoseConstraint>>;

/// Attempts until there is nothing more to try; what they found.
Closures found_by_attempts(Base& base, SessionId id) {
  Closures out;
  for (bool more = true; more;) {
    const AttemptReport report = base.pipeline.attempt(id, base.shelf);
    for (const PairClosures& pair : report.closures) out[{pair.a, pair.b}] = *pair.places;
    more = report.unfinished;
  }
  return out;
}

/// Against the truth, in standard deviations as its information tells them.
double off_sigmas(const Base& base, const PoseConstraint& c) {
  const auto truth = [&](const KeyframeRef& k) {
    return base.drive(k.session).T_mine_local * base.drive(k.session).keyframes.at(k.sequence - 1).T_local_sensor;
  };
  const Vector6d off = se3_log(c.T_from_to.inverse() * truth(c.from).inverse() * truth(c.to));
  return std::sqrt(off.dot(c.information * off));
}

double path_m(const Base& base, const KeyframeRef& to) {
  const auto& keyframes = base.drive(to.session).keyframes;
  double sum = 0;
  for (std::size_t i = 1; i < to.sequence; ++i)
    sum += (keyframes[i].T_local_sensor.translation() - keyframes[i - 1].T_local_sensor.translation()).norm();
  return sum;
}

TEST(LoopClosures, TwoMergedSessionsAreTiedAlongTheirOverlapOnceTheMergeIsTold) {
  Base base({test::drive_a_to_c(3), test::drive_b_to_a(3)});
  const AttemptReport first = base.pipeline.attempt(1, base.shelf);
  EXPECT_TRUE(first.atlas_changed);
  EXPECT_TRUE(first.closures.empty());
  EXPECT_TRUE(first.unfinished);
  const Closures found = found_by_attempts(base, 1);
  ASSERT_TRUE(found.contains({1, 2}));
  const auto& places = found.at({1, 2});
  EXPECT_GE(places.size(), 4U);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(places[i].from.session, 1);
    EXPECT_EQ(places[i].to.session, 2);
    EXPECT_LT(off_sigmas(base, places[i]), 4) << places[i].to.sequence;
    EXPECT_TRUE(i == 0 || places[i].to != places[i - 1].to);
  }
  EXPECT_GT(path_m(base, places.back().to) - path_m(base, places.front().to), 25) << "not one spot";
  EXPECT_FALSE(base.pipeline.corrections().empty());
  for (const SessionId id : {1, 2}) EXPECT_TRUE(found_by_attempts(base, id).empty()) << "all was tried";
}

TEST(LoopClosures, AtlasAndRevisionStayAsTheyWere) {
  Base base({test::drive_a_to_c(3), test::drive_b_to_a(3)});
  (void)base.pipeline.attempt(1, base.shelf);
  const Atlas before = base.pipeline.atlas();
  ASSERT_FALSE(found_by_attempts(base, 1).empty());
  EXPECT_EQ(base.pipeline.atlas().revision, before.revision);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_TRUE(base.pipeline.atlas().components[0].placements[i].T_component_session.isApprox(
        before.components[0].placements[i].T_component_session, 1e-12));
}

TEST(LoopClosures, WhatARobotStillDrivesThroughWaits) {
  MergeConfig config = test::waits_for_no_others();
  config.shown_m = config.shown_more_m = config.shown_doubt_m = config.provisional_probability = 0;
  Base base({test::drive_a_to_c(3)}, config);
  const SessionId growing = base.grow(test::drive_b_to_a(3));
  const double driven_m = path_m(base, {growing, base.drive(growing).keyframes.size()});
  const Closures early = found_by_attempts(base, growing);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  for (const auto& [pair, places] : early)
    for (const PoseConstraint& c : places) EXPECT_LE(path_m(base, c.to), driven_m - SubmapConfig{}.window_m + 1e-6);
  base.pipeline.complete_session(growing);
  const Closures late = found_by_attempts(base, growing);
  ASSERT_TRUE(late.contains({1, growing}));
  EXPECT_GT(late.at({1, growing}).size(), early.empty() ? 0 : early.at({1, growing}).size());
}

TEST(LoopClosures, WhatWasStoredIsNotRegisteredAgainAndBendsTheSame) {
  Base base({test::drive_a_to_c(3), test::drive_b_to_a(3)});
  const Closures found = found_by_attempts(base, 1);
  Base restarted(base.drives);
  for (const auto& [pair, places] : found)
    restarted.pipeline.restore_closures(
        {pair.first, pair.second, std::make_shared<const std::vector<PoseConstraint>>(places)});
  restarted.pipeline.restore(base.pipeline.alignments(), base.pipeline.atlas().revision);
  ASSERT_EQ(restarted.pipeline.corrections().size(), base.pipeline.corrections().size());
  for (const auto& [session, correction] : base.pipeline.corrections())
    for (std::size_t i = 0; i < correction->keyframes.size(); ++i)
      EXPECT_LT((correction->keyframes[i].T_component_session.translation() -
                 restarted.pipeline.corrections().at(session)->keyframes.at(i).T_component_session.translation())
                    .norm(),
                CorrectedPoses::moved_m);
  const Closures again = found_by_attempts(restarted, 1);
  EXPECT_TRUE(again.empty() || again.at({1, 2}).size() > found.at({1, 2}).size()) << "those that failed are tried anew";
}

TEST(LoopClosures, ASessionThatComesBackToItsPathMeetsItself) {
  const BoxMine mine({BoxMine::drift(0, 0, 45, 0), BoxMine::drift(45, 0, 45, 35), BoxMine::drift(45, 35, 0, 35),
                      BoxMine::drift(0, 35, 0, 0)});
  Base base({test::drive(mine, {{2, 0}, {45, 0}, {45, 35}, {0, 35}, {0, 0}, {43, 0}}, 0.3, 1)});
  const Closures found = found_by_attempts(base, 1);
  ASSERT_TRUE(found.contains({1, 1}));
  for (const PoseConstraint& c : found.at({1, 1})) {
    EXPECT_LT(off_sigmas(base, c), 4) << c.to.sequence;
    EXPECT_GE(path_m(base, c.to) - path_m(base, c.from), LoopClosureRules{}.apart_m);
  }
  EXPECT_TRUE(base.pipeline.atlas().components[0].placements[0].T_component_session.isApprox(Pose::Identity(), 0));
  base.pipeline.set_aside(1);
  EXPECT_TRUE(base.pipeline.corrections().empty());
}

TEST(LoopClosures, ASessionWithoutKeyframesHasNone) {
  Base base({});
  base.pipeline.add_session(1, ScanContext().id());
  EXPECT_TRUE(base.pipeline.attempt(1, base.shelf).closures.empty());
}

}  // namespace
}  // namespace headframe
