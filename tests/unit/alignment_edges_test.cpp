#include "server/merge/alignment_edges.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

Session along(const Eigen::Vector3d& from, const Eigen::Vector3d& to, int keyframes) {
  Session out;
  for (int i = 0; i < keyframes; ++i) {
    Keyframe k;
    k.sequence = static_cast<std::uint64_t>(i) + 1;
    k.T_local_sensor.translation() = from + i * (to - from) / std::max(1, keyframes - 1);
    out.keyframes.push_back(std::move(k));
    out.path_to_m.push_back((from - to).norm() * i / std::max(1, keyframes - 1));
  }
  return out;
}

TEST(WhereTheyMeet, IsTheMiddleOfTheOverlapFromBothSides) {
  const Pose T_a_b = pose_from_yaw(1.2, {100, -50, 3});
  const Session a = along({0, 0, 0}, {200, 0, 0}, 101);
  // b comes along the last 50 m of a, 2 m beside it, and goes on for 300 m.
  const Eigen::Vector3d from = T_a_b.inverse() * Eigen::Vector3d(150, 2, 0),
                        to = T_a_b.inverse() * Eigen::Vector3d(500, 2, 0);
  const Session b = along(from, to, 351);
  const Eigen::Vector3d middle = T_a_b * where_they_meet(a, b, T_a_b);
  EXPECT_NEAR(middle.x(), 175, 6);
  EXPECT_NEAR(middle.y(), 1, 1);
  EXPECT_LT((middle - where_they_meet(b, a, T_a_b.inverse())).norm(), 1e-9) << "whichever is called a";
  const Pose T_b_c = pose_from_yaw(-2, {7, 8, 9});
  const Session c = along(T_b_c.inverse() * from, T_b_c.inverse() * to, 351);
  EXPECT_LT((middle - T_a_b * T_b_c * where_they_meet(a, c, T_a_b * T_b_c)).norm(), 1e-9) << "in whatever frame";
}

TEST(WhereTheyMeet, IsHalfWayBetweenTheNearestTwoWherePathsNeverMeet) {
  const Session a = along({0, 0, 0}, {100, 0, 0}, 51), b = along({60, 20, 0}, {60, 90, 0}, 36);
  const Eigen::Vector3d here = where_they_meet(a, b, Pose::Identity());
  EXPECT_LT((here - Eigen::Vector3d(60, 10, 0)).norm(), 1e-9);
}

TEST(WhereTheyMeet, FindsACrossingOfLongDrivesThatAreLookedAtThinly) {
  const Session a = along({-5000, 0, 0}, {5000, 0, 0}, 5001), b = along({1234, -4000, 0}, {1234, 4000, 0}, 4001);
  EXPECT_LT((where_they_meet(a, b, Pose::Identity()) - Eigen::Vector3d(1234, 0, 0)).norm(), 60);
  EXPECT_EQ(where_they_meet(a, Session{}, Pose::Identity()), Eigen::Vector3d::Zero());
}

TEST(WhereThePastWasMoved, ARigidMoveIsTakenBackExactly) {
  const Session was = along({0, 0, 0}, {200, 0, 0}, 101), other = along({150, 2, 0}, {300, 2, 0}, 76);
  const Pose T_now_was = pose_from_yaw(0.7, {30, -20, 5});
  std::vector<Keyframe> now = was.keyframes;
  for (Keyframe& k : now) k.T_local_sensor = T_now_was * k.T_local_sensor;
  EXPECT_TRUE(T_was_now_where_they_meet(was, now, other, Pose::Identity()).isApprox(T_now_was.inverse(), 1e-9));
  EXPECT_TRUE(T_was_now_where_they_meet(was, was.keyframes, Session{}, Pose::Identity()).isApprox(Pose::Identity()));
  EXPECT_TRUE(T_was_now_where_they_meet(was, {}, other, Pose::Identity()).isApprox(Pose::Identity()));
}

TEST(WhereThePastWasMoved, OfOneThatWasBentOnlyWhereTheyMeetCounts) {
  const Session was = along({0, 0, 0}, {200, 0, 0}, 101), other = along({150, 2, 0}, {300, 2, 0}, 76);
  std::vector<Keyframe> now = was.keyframes;
  for (std::size_t i = 1; i < now.size(); ++i) {  // each step turns a little
    const Pose step = was.keyframes[i - 1].T_local_sensor.inverse() * was.keyframes[i].T_local_sensor;
    now[i].T_local_sensor = now[i - 1].T_local_sensor * pose_from_yaw(0.001, {0, 0, 0}) * step;
  }
  const Pose T_was_now = T_was_now_where_they_meet(was, now, other, Pose::Identity());
  Eigen::Vector3d off = Eigen::Vector3d::Zero();
  for (std::size_t i = 71; i < now.size(); ++i) {  // from 142 m on, some 10 m before the other's end
    const Eigen::Vector3d p = T_was_now * position(now[i]) - position(was.keyframes[i]);
    EXPECT_LT(p.norm(), 0.5) << i;
    off += p;
  }
  EXPECT_LT(off.norm() / 30, 0.05) << "in the middle of it nothing moves";
  EXPECT_GT((T_was_now * position(now[0])).norm(), 5) << "far from there it does";
}

}  // namespace
}  // namespace headframe
