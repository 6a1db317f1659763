// Odometry that jumps: a robot that was carried, or a filter that lost its way. What lies on both sides of a jump is
// held together by nothing.

#include <gtest/gtest.h>

#include "server/place/odometry_jump.hpp"
#include "tests/scenario/drawn_base.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe {
namespace {

using test::Base;
using test::carried;
using test::Drive;
using test::other_mine;

void settle(Base& base) {
  for (int round = 0; round < 2; ++round)
    for (std::size_t i = 0; i < base.drives.size(); ++i) {
      base.pipeline.complete_session(static_cast<SessionId>(i + 1));
      base.pipeline.attempt(static_cast<SessionId>(i + 1), base.shelf);
    }
}

bool together(const Base& base, SessionId a, SessionId b) {
  for (const Component& component : base.pipeline.atlas().components) {
    const auto has = [&](SessionId id) {
      return std::any_of(component.placements.begin(), component.placements.end(),
                         [&](const Placement& p) { return p.session == id; });
    };
    if (has(a) && has(b)) return true;
  }
  return false;
}

TEST(Jumps, ARobotThatWasCarriedDoesNotJoinTwoMines) {
  const Drive in_one = test::drive_b_to_a(3);
  const Drive in_other = test::drive(other_mine(), {{78, 0}, {55, 0}, {55, 28}}, 0.7, 5);
  for (const auto& by_m : {Eigen::Vector3d(400, 0, 0), Eigen::Vector3d(0, 0, 12), Eigen::Vector3d(40, 0, 0)}) {
    const Drive both = carried(test::drive_a_to_c(3), test::drive(other_mine(), {{2, 0}, {78, 0}}, 0, 4), by_m);
    Base base({both, in_one, in_other});
    settle(base);
    EXPECT_FALSE(together(base, 2, 3)) << by_m.transpose();
    EXPECT_TRUE(together(base, 1, 2)) << "what came before the jump is as good as ever, " << by_m.transpose();
    EXPECT_NE(base.pipeline.cut(1).why, "");
    EXPECT_EQ(base.pipeline.cut(2).why, "");
  }
}

TEST(Jumps, AKeyframeOffThePathIsForgiven) {
  Drive glitched = test::drive_a_to_c(3);
  glitched.keyframes[6].T_local_sensor.translation() += Eigen::Vector3d(300, -80, 5);
  Base base({glitched, test::drive_b_to_a(3)});
  settle(base);
  EXPECT_TRUE(together(base, 1, 2));
  EXPECT_EQ(base.pipeline.cut(1).why, "");
  EXPECT_LT(base.error_m(), 0.15);
}

/// As the selection leaves them: none nearer than 2.9 m to an earlier one.
Drive as_selected(const Drive& all) {
  Drive out;
  out.T_mine_local = all.T_mine_local;
  for (std::size_t i = 0; i < all.keyframes.size(); ++i) {
    const auto near = [&](const Keyframe& k) {
      return (k.T_local_sensor.translation() - all.keyframes[i].T_local_sensor.translation()).norm() < 2.9;
    };
    if (std::any_of(out.keyframes.begin(), out.keyframes.end(), near)) continue;
    out.keyframes.push_back(all.keyframes[i]);
    out.keyframes.back().sequence = out.keyframes.size();
    out.clouds.push_back(all.clouds[i]);
  }
  return out;
}

TEST(Jumps, WhoDrivesBackOverItsPathIsNotCut) {
  const Drive back = as_selected(test::drive(other_mine(), {{2, 0}, {78, 0}, {20, 0}, {20, -33}}, 0, 6));
  const auto farthest_m = [&] {
    double out = 0;
    for (std::size_t i = 1; i < back.keyframes.size(); ++i)
      out = std::max(
          out,
          (back.keyframes[i].T_local_sensor.translation() - back.keyframes[i - 1].T_local_sensor.translation()).norm());
    return out;
  };
  ASSERT_GT(farthest_m(), 50) << "where it drives on there is no keyframe near the last one";
  MergeConfig config = test::waits_for_no_others();
  config.shown_more_m = config.shown_doubt_m = 0;  // the second drive is short, and this mine is all alike
  Base base({back, test::drive(other_mine(), {{20, -33}, {20, 0}, {30, 0}}, 0.7, 7)}, config);
  settle(base);
  EXPECT_EQ(base.pipeline.cut(1).why, "");
  EXPECT_TRUE(together(base, 1, 2)) << "by what came after the way back";
  EXPECT_LT(base.error_m(), 0.15);
}

TEST(Jumps, BesideItsOwnPathItMustSeeTheSame) {
  const Drive along = test::drive(other_mine(), {{2, 0}, {78, 0}}, 0, 4),
              across = test::drive(other_mine(), {{20, -33}, {20, -3}}, 0, 5);
  const auto jumps_to = [&](Keyframe keyframe, double x_m) {
    keyframe.T_local_sensor.translation() = Eigen::Vector3d(x_m, 0, 0);
    keyframe.stamp_s = along.keyframes.back().stamp_s + 600;
    return jump_between(along.keyframes.back(), keyframe, along.keyframes).has_value();
  };
  EXPECT_FALSE(jumps_to(along.keyframes[3], 10)) << "back where it was";
  EXPECT_TRUE(jumps_to(across.keyframes[5], 10)) << "other walls: odometry that began at zero again";
  EXPECT_TRUE(jumps_to(along.keyframes[3], -20)) << "beside nothing";
}

TEST(Jumps, OfWhoJumpsToAndFroOnlyTheFirstPlaceCounts) {
  Drive jumper = test::drive_a_to_c(3);
  for (std::size_t i = 0; i < jumper.keyframes.size(); ++i)
    jumper.keyframes[i].T_local_sensor.translation() += Eigen::Vector3d(i % 2 == 0 ? 0 : 340, i % 4 < 2 ? 0 : 340, 0);
  Base base({test::drive_b_to_a(3), jumper});
  settle(base);
  EXPECT_NE(base.pipeline.cut(2).why, "");
  EXPECT_LT(base.error_m(), 0.5) << "what stands where it began may merge, what lies elsewhere is not looked at";
}

TEST(Jumps, WhatNoRobotDrivesAndWhatOneMay) {
  const auto step = [](double x, double z, double s) {
    Keyframe a, b;
    a.stamp_s = 100;
    b.stamp_s = 100 + s;
    b.T_local_sensor.translation() = Eigen::Vector3d(x, 0, z);
    return jump_between(a, b).has_value();
  };
  EXPECT_FALSE(step(2, 0.5, 0.2));
  EXPECT_FALSE(step(10, 3, 1)) << "a fast car on a ramp";
  EXPECT_FALSE(step(3, 0, 0)) << "no clock";
  EXPECT_FALSE(step(1, 2, 10)) << "a steep raise";
  EXPECT_FALSE(step(1, 6, 2)) << "a drone in a shaft";
  EXPECT_FALSE(step(0, -9.5, 5)) << "and down again";
  EXPECT_TRUE(step(1, 6, 0.5)) << "no drone climbs so fast";
  EXPECT_TRUE(step(1, 8, 60)) << "it was carried up";
  EXPECT_TRUE(step(0, 6, 0)) << "no clock";
  EXPECT_TRUE(step(26, 0, 60));
  EXPECT_TRUE(step(15, 0, 0.1));
  EXPECT_TRUE(step(1, 12, 600)) << "a shaft";
}

}  // namespace
}  // namespace headframe
