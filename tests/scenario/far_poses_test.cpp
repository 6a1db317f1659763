// Robots may count their metres from anywhere that the protocol allows, and may be out of their minds.

#include <gtest/gtest.h>

#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::Base;
using test::Drive;

/// The drive as a robot tells it whose frame has its origin elsewhere.
Drive counted_from(Drive drive, const Eigen::Vector3d& origin_m) {
  const Pose T_new_old(Eigen::Translation3d(-origin_m));
  for (Keyframe& keyframe : drive.keyframes) keyframe.T_local_sensor = T_new_old * keyframe.T_local_sensor;
  drive.T_mine_local = drive.T_mine_local * T_new_old.inverse();
  return drive;
}

Drive utm(const Drive& drive) { return counted_from(drive, {-5e5, -5e6, -312.5}); }

void complete(Base& base) {
  for (std::size_t i = 0; i < base.drives.size(); ++i) {
    base.pipeline.complete_session(static_cast<SessionId>(i + 1));
    base.pipeline.attempt(static_cast<SessionId>(i + 1), base.shelf);
    while (base.pipeline.prepare_ahead(base.shelf)) {
    }
  }
}

/// How far a point of the second session, at its first keyframe, is from where it should be in the first's frame.
double error_at_first_keyframe_m(const Base& base) {
  const Component& all = base.pipeline.atlas().components.at(0);
  const Pose T_1_2 = all.placements.at(0).T_component_session.inverse() * all.placements.at(1).T_component_session;
  const Pose truth = base.drive(1).T_mine_local.inverse() * base.drive(2).T_mine_local;
  const Eigen::Vector3d p = base.drive(2).keyframes.front().T_local_sensor.translation();
  return (T_1_2 * p - truth * p).norm();
}

TEST(FarPoses, SessionsWithAFarOriginMerge) {
  for (const auto& [a, b] : {std::pair(utm(test::drive_a_to_c(3)), utm(test::drive_b_to_a(3))),
                             std::pair(utm(test::drive_a_to_c(3)), test::drive_b_to_a(3))}) {
    MergeConfig config = test::waits_for_no_others();
    config.accept_probability = 0.8;  // 35 m among look-alikes: what counts here is where it lies
    Base base({a, b}, config);
    complete(base);
    ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
    EXPECT_LT(error_at_first_keyframe_m(base), 0.15);
  }
}

TEST(FarPoses, WhatIsToldOfThemIsTakenBackAfterARestart) {
  Base base({utm(test::drive_a_to_c(3)), test::drive_b_to_a(3)});
  complete(base);
  const AttemptReport confirmed = base.pipeline.decide(1, Decision::confirm).value();
  Base later({utm(test::drive_a_to_c(3)), test::drive_b_to_a(3)});
  later.pipeline.restore(base.pipeline.alignments(), base.pipeline.atlas().revision, confirmed.decided);
  ASSERT_EQ(later.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(later.pipeline.alignments().at(0).ruling, Ruling::confirmed);
  EXPECT_LT(error_at_first_keyframe_m(later), 0.15);
  EXPECT_FALSE(later.pipeline.attempt(1, later.shelf).atlas_changed) << "nothing new, no new revision";
}

TEST(FarPoses, PosesBeyondAllReasonHarmNobody) {
  for (const double far_m : {2e7, 5e7, 1e8}) {
    Drive all_far = counted_from(test::drive_b_to_a(3), {-far_m, far_m, 0}), flung = test::drive_d_to_b(3);
    all_far.keyframes.resize(2);
    all_far.clouds.resize(2);
    for (std::size_t i = 3; i < flung.keyframes.size(); ++i)
      flung.keyframes[i].T_local_sensor.translation() += Eigen::Vector3d(i % 2 == 0 ? far_m : -far_m, far_m, -far_m);
    Base base({test::drive_a_to_c(3), test::drive_b_to_a(3), all_far, flung});
    complete(base);
    const auto& components = base.pipeline.atlas().components;
    EXPECT_TRUE(std::any_of(components.begin(), components.end(), [](const Component& c) {
      return c.placements.size() >= 2 && c.placements[0].session == 1 && c.placements[1].session == 2;
    })) << "the honest two are one map beside it";
  }
}

}  // namespace
}  // namespace headframe
