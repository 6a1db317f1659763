#include "server/merge/corrected_poses.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/atlas/merge_graph.hpp"
#include "server/merge/alignment_edges.hpp"
#include "server/merge/frozen_places.hpp"
#include "server/merge/odometry_chain.hpp"

namespace headframe {
namespace {

// The mine of these tests: a square of 60 m. Session 1 drives from A by B to C, session 2 from A by D to C, session 3 a
// gallery that leaves A, and session 4 one far from all, of another component.
//
//     D --- C
//     |     |
//     A --- B
//     |
//     E
using Way = std::vector<Eigen::Vector2d>;
const Eigen::Vector2d A(0, 0), B(60, 0), C(60, 60), D(0, 60), E(0, -60);

struct Drive {
  std::vector<Pose> truth, believed;
};

/// A keyframe every 2 m. The believed path bends by 0.03 deg with every metre.
Drive drive(const Way& way, double bend) {
  Drive out;
  for (std::size_t leg = 0; leg + 1 < way.size(); ++leg) {
    const Eigen::Vector2d along = (way[leg + 1] - way[leg]).normalized();
    for (double s = 0; s < (way[leg + 1] - way[leg]).norm(); s += 2) {
      const Eigen::Vector2d p = way[leg] + s * along;
      const Pose T = pose_from_yaw(std::atan2(along.y(), along.x()), {p.x(), p.y(), 0});
      out.believed.push_back(out.truth.empty() ? Pose::Identity()
                                               : out.believed.back() * out.truth.back().inverse() * T *
                                                     pose_from_yaw(bend, {0.01, 0, 0}));
      out.truth.push_back(T);
    }
  }
  return out;
}

class CorrectedPosesTest : public ::testing::Test {
 protected:
  void add(SessionId id, const Drive& drive) {
    drives_[id] = drive;
    sessions_.add(id, {});
    for (std::size_t i = 0; i < drive.believed.size(); ++i) {
      Keyframe k;
      k.sequence = i + 1;
      k.stamp_s = 2 * static_cast<double>(i);
      k.T_local_sensor = drive.believed[i];
      sessions_.add_keyframe(id, std::move(k));
    }
  }

  /// True, at these places along both drives (indices of keyframes of a and b).
  Alignment aligned(SessionId a, SessionId b, const std::vector<std::pair<std::size_t, std::size_t>>& places,
                    const Pose& error = Pose::Identity()) {
    const Drive &in_a = drives_.at(a), &in_b = drives_.at(b);
    Alignment k;
    k.id = 10 * a + b;
    k.a = a, k.b = b;
    k.state = AlignmentState::published;
    std::vector<PoseConstraint> closures;
    for (const auto& [i, j] : places) {
      Registration r;
      r.T_target_source =
          in_a.believed[i] * in_a.truth[i].inverse() * error * in_b.truth[j] * in_b.believed[j].inverse();
      r.information.diagonal() << 1e6, 1e6, 1e6, 1e4, 1e4, 1e4;
      r.centre = in_a.believed[i].translation();
      closures.push_back(constraint_between({a, i + 1}, in_a.believed[i], {b, j + 1}, in_b.believed[j], place_fit(r)));
      k.T_a_b = r.T_target_source;
    }
    closures_[{a, b}] = std::make_shared<const std::vector<PoseConstraint>>(std::move(closures));
    return k;
  }

  std::vector<Component> components(const std::vector<Alignment>& alignments, std::vector<SessionId> anchors = {}) {
    std::vector<SessionId> ids;
    for (const auto& [id, session] : sessions_.all()) ids.push_back(id);
    return merge_sessions(ids, alignments, {5, 0.2}, anchors).components;
  }
  std::vector<Component> update(CorrectedPoses& poses, const std::vector<Alignment>& alignments,
                                std::vector<SessionId> anchors = {}) {
    std::vector<Component> out = components(alignments, std::move(anchors));
    for (const auto& [pair, closures] : closures_) poses.set({pair.first, pair.second, closures});
    poses.update(out, alignments);
    return out;
  }

  /// With what is frozen.
  std::vector<Component> components_held(const std::vector<Alignment>& alignments) {
    std::vector<SessionId> ids;
    for (const auto& [id, session] : sessions_.all()) ids.push_back(id);
    return merge_sessions(ids, alignments, {5, 0.2}, {}, {}, sessions_.frozen()).components;
  }

  std::vector<Eigen::Vector3d> placed(const CorrectedPoses& poses, const Component& component) const {
    std::vector<Eigen::Vector3d> out;
    for (const Placement& p : component.placements) {
      const Drive& d = drives_.at(p.session);
      const auto found = poses.given_out().find(p.session);
      for (std::size_t i = 0; i < d.believed.size(); ++i)
        out.push_back((found == poses.given_out().end() ? p.T_component_session * d.believed[i]
                                                        : found->second->corrected(i + 1, d.believed[i]))
                          .translation());
    }
    return out;
  }
  /// Root mean square, after the rigid transform that lays all on the truth best.
  double error_m(const std::vector<Eigen::Vector3d>& placed, const Component& component) const {
    Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(placed.size())), to = from;
    Eigen::Index at = 0;
    for (const Placement& p : component.placements)
      for (const Pose& T : drives_.at(p.session).truth) {
        from.col(at) = placed[static_cast<std::size_t>(at)];
        to.col(at++) = T.translation();
      }
    const Pose T(Eigen::umeyama(from, to, false));
    return std::sqrt(((T * from) - to).colwise().squaredNorm().mean());
  }
  std::vector<Eigen::Vector3d> rigid(const Component& component) const {
    return placed(CorrectedPoses(sessions_), component);
  }

  static Eigen::Matrix4d umeyama(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
    Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(a.size())), to = from;
    for (std::size_t i = 0; i < a.size(); ++i) {
      from.col(static_cast<Eigen::Index>(i)) = a[i];
      to.col(static_cast<Eigen::Index>(i)) = b[i];
    }
    return Eigen::umeyama(from, to, false);
  }

  static constexpr double bend = 0.001;
  void square() {
    add(1, drive({A, B, C}, bend));
    add(2, drive({A, D, C}, bend));
    loop_ = {aligned(1, 2, {{0, 0}, {59, 59}})};  // where both begin, and where both end
  }

  MergeConfig config_;
  SessionMap sessions_{config_};
  std::map<SessionId, Drive> drives_;
  std::vector<Alignment> loop_;
  std::map<std::pair<SessionId, SessionId>, PoseConstraints> closures_;
};

double farthest_m(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).norm());
  return most;
}

TEST_F(CorrectedPosesTest, ALoopOfTwoSessionsLosesItsDrift) {
  square();
  CorrectedPoses poses(sessions_);
  const Component before = components(loop_).at(0);
  const std::vector<Component> after = update(poses, loop_);
  ASSERT_EQ(after.size(), 1U);
  const double rigid_m = error_m(rigid(before), before), bent_m = error_m(placed(poses, after[0]), after[0]);
  EXPECT_GT(rigid_m, 0.5);
  EXPECT_LT(bent_m, 0.6 * rigid_m);
  const auto all = placed(poses, after[0]);
  EXPECT_NEAR((all[59] - all[119]).norm(), std::sqrt(8), 0.1);  // each stops 2 m before C
  EXPECT_LT(farthest_m({all[0]}, {drives_.at(1).believed[0].translation()}), 1e-6) << "the anchor's first stays";
}

/// Bent by a loop, frozen so, and then told something else: nothing of it moves, and the other gives way all the more.
TEST_F(CorrectedPosesTest, AFrozenSessionStaysBentAsItWas) {
  square();
  CorrectedPoses poses(sessions_);
  Atlas atlas;
  atlas.components = update(poses, loop_);
  const auto of = [&](SessionId session, const Component& component) {
    return placed(poses, {component.id, {*placement_in(component, session)}});
  };
  const auto was = of(2, atlas.components[0]), other_was = of(1, atlas.components[0]);
  FrozenSession two = frozen_now(2, atlas, poses.given_out(), {});
  EXPECT_EQ(two.frame, 2);
  sessions_.freeze(two);
  const auto held = components_held(loop_);
  ASSERT_EQ(held[0].id, 2);
  loop_ = {aligned(1, 2, {{0, 0}, {30, 30}, {59, 59}}, pose_from_yaw(0, {0.4, 0, 0}))};
  std::vector<Component> after = components_held(loop_);
  for (const auto& [pair, closures] : closures_) poses.set({pair.first, pair.second, closures});
  poses.update(after, loop_);
  const auto is = of(2, after[0]);
  const Pose T_new_old = Pose(umeyama(was, is));
  const auto moved = [&](std::vector<Eigen::Vector3d> points) {
    for (auto& p : points) p = T_new_old * p;
    return points;
  };
  const std::vector<Eigen::Vector3d> moved_along = moved(was);
  EXPECT_LT(farthest_m(moved_along, is), 1e-6) << "bent as it was";
  EXPECT_LT((is[0] - drives_.at(2).believed[0].translation()).norm(), 1e-6) << "its first stays in its own frame";
  const std::vector<Eigen::Vector3d> other_along = moved(other_was);
  EXPECT_GT(farthest_m(other_along, of(1, after[0])), 0.2) << "the other gives way";
  EXPECT_TRUE(sessions_.thaw(2));
  poses.touch(2);
  const auto thawed = update(poses, loop_);
  EXPECT_EQ(thawed[0].id, 1);
}

/// Both frozen: the frame of the second is that of the first, and nothing between them counts any more.
TEST_F(CorrectedPosesTest, TwoFrozenSessionsStayWhereTheyWereToEachOther) {
  square();
  add(3, drive({{2, 0}, A, E}, bend));
  loop_.push_back(aligned(1, 3, {{0, 1}, {1, 0}}));
  CorrectedPoses poses(sessions_);
  Atlas atlas;
  atlas.components = update(poses, loop_);
  for (const SessionId id : {1, 2}) sessions_.freeze(frozen_now(id, atlas, poses.given_out(), sessions_.frozen()));
  EXPECT_EQ(sessions_.frozen().at(2).frame, 1);
  const auto before = placed(poses, {1, {atlas.components[0].placements[0], atlas.components[0].placements[1]}});
  loop_ = {aligned(1, 2, {{0, 0}, {59, 59}}, pose_from_yaw(0.01, {0.5, 0.5, 0})), aligned(2, 3, {{0, 1}})};
  auto after = components_held(loop_);
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(after[0].id, 1);
  for (const auto& [pair, closures] : closures_) poses.set({pair.first, pair.second, closures});
  poses.update(after, loop_);
  EXPECT_LT(farthest_m(before, placed(poses, {1, {after[0].placements[0], after[0].placements[1]}})), 1e-6);
}

TEST_F(CorrectedPosesTest, SessionsWithoutConstraintsStayRigid) {
  square();
  add(4, drive({{500, 0}, {560, 0}}, bend));
  CorrectedPoses poses(sessions_);
  const auto after = update(poses, loop_);
  EXPECT_FALSE(poses.given_out().contains(4));
  EXPECT_TRUE(after.back().placements[0].T_component_session.isApprox(Pose::Identity(), 0));
}

TEST_F(CorrectedPosesTest, OneByOneEndsWhereAllAtOnceDo) {
  square();
  add(3, drive({{2, 0}, A, E}, bend));
  std::vector<Alignment> all = loop_;
  all.push_back(aligned(1, 3, {{0, 1}, {1, 0}}));
  CorrectedPoses at_once(sessions_), one_by_one(sessions_);
  const auto whole = update(at_once, all);
  update(one_by_one, {all[1]});
  const auto grown = update(one_by_one, all);
  EXPECT_LT(farthest_m(placed(at_once, whole[0]), placed(one_by_one, grown[0])), 0.05);
  // The same again: nothing is new, nothing moves.
  const auto before = placed(one_by_one, grown[0]);
  EXPECT_EQ(farthest_m(before, placed(one_by_one, update(one_by_one, all)[0])), 0);
}

TEST_F(CorrectedPosesTest, TheSameAfterARestart) {
  square();
  CorrectedPoses first(sessions_), second(sessions_);
  const auto one = update(first, loop_), other = update(second, loop_);
  EXPECT_EQ(farthest_m(placed(first, one[0]), placed(second, other[0])), 0);
}

TEST_F(CorrectedPosesTest, AnotherAnchorMovesEverythingAndBendsNothing) {
  square();
  CorrectedPoses poses(sessions_);
  const auto by_1 = update(poses, loop_);
  const auto all_1 = placed(poses, by_1[0]);
  const auto by_2 = update(poses, loop_, {2});
  ASSERT_EQ(by_2[0].id, 2);
  const auto all_2 = placed(poses, by_2[0]);
  EXPECT_LT(farthest_m({all_2[60]}, {drives_.at(2).believed[0].translation()}), 1e-6);
  for (std::size_t i = 1; i < all_1.size(); ++i)
    EXPECT_NEAR((all_1[i] - all_1[0]).norm(), (all_2[i] - all_2[0]).norm(), 1e-6) << i;
}

TEST_F(CorrectedPosesTest, ComponentsThatMergeKeepTheirShape) {
  square();
  add(3, drive({{2, 0}, A, E}, bend));
  CorrectedPoses poses(sessions_);
  const auto apart = update(poses, loop_);
  const auto before = placed(poses, apart[0]);
  std::vector<Alignment> all = loop_;
  all.push_back(aligned(1, 3, {{0, 1}}));
  const auto whole = update(poses, all);
  const auto after = placed(poses, whole[0]);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_LT((before[i] - after[i]).norm(), 0.05) << i;
}

TEST_F(CorrectedPosesTest, WhatIsWithdrawnNoLongerBends) {
  square();
  CorrectedPoses poses(sessions_);
  update(poses, loop_);
  std::vector<Alignment> none = loop_;
  none[0].state = AlignmentState::retracted;
  std::vector<Component> alone = components({});
  poses.update(alone, none);
  EXPECT_TRUE(poses.given_out().empty());
  for (const Component& c : alone) EXPECT_TRUE(c.placements[0].T_component_session.isApprox(Pose::Identity(), 0));
}

// A place that was registered elsewhere than its alignment says is of another placement of the pair.
TEST_F(CorrectedPosesTest, PlacesOfAnotherPlacementAreLeftOut) {
  square();
  Alignment k = loop_[0];
  const PoseConstraints places = closures_.at({1, 2});
  EXPECT_EQ(edges_of(k, places, sessions_).size(), 3U);  // two places, and the whole
  k.T_a_b = Pose(Eigen::Translation3d(0, 30, 0)) * k.T_a_b;
  const auto edges = edges_of(k, places, sessions_);
  for (const PoseConstraint& c : edges) EXPECT_LT(c.information.maxCoeff(), 1 / (0.01 * 0.01));
  EXPECT_FALSE(edges_of(k, nullptr, sessions_).empty()) << "none was found yet";
}

TEST_F(CorrectedPosesTest, ASessionAloneIsBentWhereItMeetsItselfAndKeepsItsFrame) {
  add(1, drive({A, B, C, D, A, B}, bend));
  CorrectedPoses poses(sessions_);
  const Drive& d = drives_.at(1);
  const std::vector<PoseConstraint> loop{
      constraint_between({1, 1}, d.believed[0], {1, 121}, d.believed[120],
                         {d.believed[0] * d.truth[0].inverse() * d.truth[120] * d.believed[120].inverse(),
                          d.believed[0].translation(), 1000 * Matrix6d::Identity()})};
  poses.set({1, 1, std::make_shared<const std::vector<PoseConstraint>>(loop)});
  const Component before = components({}).at(0);
  const auto after = update(poses, {});
  EXPECT_TRUE(after[0].placements[0].T_component_session.isApprox(Pose::Identity(), 0));
  EXPECT_LT(error_m(placed(poses, after[0]), after[0]), 0.5 * error_m(rigid(before), before));
}

TEST_F(CorrectedPosesTest, NodesStandNoFartherApartThanAsked) {
  add(1, drive({A, B, C}, 0));
  const Session& session = sessions_.at(1);
  const auto nodes = chain_nodes(session, {7, 8}, 10);
  EXPECT_EQ(nodes.front(), 0U);
  EXPECT_EQ(nodes.back(), 59U);
  for (const std::size_t asked : {7U, 8U}) EXPECT_TRUE(std::find(nodes.begin(), nodes.end(), asked) != nodes.end());
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
    EXPECT_LE(session.path_to_m[nodes[i + 1]] - session.path_to_m[nodes[i]], 10 + 1e-9);
  EXPECT_LT(nodes.size(), 20U);
}

TEST_F(CorrectedPosesTest, OdometryIsLessSureTheFartherAndTheMoreItTurns) {
  add(1, drive({A, B, C}, 0));
  const Session& session = sessions_.at(1);
  const auto sure = [&](std::size_t from, std::size_t to) {
    return odometry_edge(session, from, to, 0, 1).information;
  };
  EXPECT_GT(sure(0, 5)(3, 3), sure(0, 10)(3, 3));
  EXPECT_GT(sure(0, 5)(2, 2), sure(27, 32)(2, 2));  // round the corner at B
  EXPECT_TRUE(odometry_edge(session, 3, 9, 0, 1)
                  .T_from_to.isApprox(drives_.at(1).believed[3].inverse() * drives_.at(1).believed[9], 1e-9));
}

}  // namespace
}  // namespace headframe
