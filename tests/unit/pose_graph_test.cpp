#include "server/atlas/pose_graph.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <limits>
#include <numbers>
#include <random>

namespace headframe {
namespace {

constexpr double deg = std::numbers::pi / 180;

// The graph of these tests: a robot drives once round a square of 40 m, a node every 4 m, and closes the loop.
//
//     10 - 9 - 8 ...
//     |            |
//     .. 38 - 0 = 40 (the last node truly stands where the first does)
constexpr std::size_t nodes_round = 41;

Pose true_pose(std::size_t i) {
  const double s = 4.0 * static_cast<double>(i % 40);
  const int side = static_cast<int>(s / 40);
  const double along = s - 40 * side;
  const std::array<Eigen::Vector2d, 4> corners{{{0, 0}, {40, 0}, {40, 40}, {0, 40}}};
  const std::array<Eigen::Vector2d, 4> ways{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const Eigen::Vector2d p = corners[static_cast<std::size_t>(side)] + along * ways[static_cast<std::size_t>(side)];
  return pose_from_yaw(90 * deg * side, {p.x(), p.y(), 0.1 * std::sin(s / 10)});
}

Pose between(std::size_t i, std::size_t k) { return true_pose(i).inverse() * true_pose(k); }

/// Odometry that turns 0.05 deg too far with every metre, and its poses as the search begins.
PoseGraph driven_round(double drift = 1) {
  PoseGraph graph;
  graph.nodes.resize(nodes_round);
  graph.nodes[0] = {true_pose(0), true};
  for (std::size_t i = 1; i < nodes_round; ++i) {
    const Pose T = between(i - 1, i) * pose_from_yaw(drift * 0.2 * deg, {0.02 * drift, 0, 0});
    graph.edges.push_back({i - 1, i, T, information_of(0.2 * deg, 0.05)});
    graph.nodes[i].T_graph_node = graph.nodes[i - 1].T_graph_node * T;
  }
  return graph;
}

PoseEdge closure(std::size_t from, std::size_t to, const Pose& error = Pose::Identity()) {
  return {from, to, between(from, to) * error, information_of(0.2 * deg, 0.04), true};
}

double rms_m(const std::vector<Pose>& poses) {
  double squared = 0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    squared += (poses[i].translation() - true_pose(i).translation()).squaredNorm();
  return std::sqrt(squared / static_cast<double>(poses.size()));
}

std::vector<Pose> begun(const PoseGraph& graph) {
  std::vector<Pose> poses;
  for (const PoseNode& node : graph.nodes) poses.push_back(node.T_graph_node);
  return poses;
}

double farthest_m(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i].translation() - b[i].translation()).norm());
  return most;
}

/// The oracle: Gauss-Newton with a dense matrix and finite differences, no kernel, rotations by the exact logarithm.
std::vector<Pose> dense_solve(const PoseGraph& graph) {
  std::vector<Pose> poses = begun(graph);
  const auto n = static_cast<Eigen::Index>(6 * (poses.size() - 1));  // node 0 is fixed
  const auto residuals = [&](const std::vector<Pose>& at) {
    Eigen::VectorXd r(static_cast<Eigen::Index>(6 * graph.edges.size()));
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      const PoseEdge& edge = graph.edges[k];
      const Eigen::LLT<Matrix6d> root(edge.information);
      r.segment<6>(static_cast<Eigen::Index>(6 * k)) =
          root.matrixU() * se3_log(edge.T_from_to.inverse() * at[edge.from].inverse() * at[edge.to]);
    }
    return r;
  };
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Eigen::VectorXd r = residuals(poses);
    Eigen::MatrixXd J(r.size(), n);
    for (Eigen::Index column = 0; column < n; ++column) {
      constexpr double step = 1e-6;
      Vector6d d = Vector6d::Zero();
      d[column % 6] = step;
      std::vector<Pose> moved = poses;
      Pose& T = moved[static_cast<std::size_t>(column / 6 + 1)];
      T = T * se3_exp(d);
      J.col(column) = (residuals(moved) - r) / step;
    }
    const Eigen::VectorXd d = -(J.transpose() * J).ldlt().solve(J.transpose() * r);
    for (std::size_t i = 1; i < poses.size(); ++i)
      poses[i] = orthonormalised(poses[i] * se3_exp(d.segment<6>(static_cast<Eigen::Index>(6 * (i - 1)))));
    if (d.norm() < 1e-9) break;
  }
  return poses;
}

TEST(PoseGraph, FindsWhatADenseSolveFinds) {
  PoseGraph graph = driven_round();
  graph.edges.push_back(closure(0, 40));
  graph.edges.push_back(closure(5, 20, pose_from_yaw(0.3 * deg, {0.05, -0.03, 0.02})));
  for (PoseEdge& edge : graph.edges) edge.may_be_wrong = false;
  const PoseGraphResult result = optimise(graph);
  ASSERT_EQ(result.status, PoseGraphStatus::converged);
  const std::vector<Pose> oracle = dense_solve(graph);
  EXPECT_LT(farthest_m(result.T_graph_node, oracle), 1e-3);
  EXPECT_GT(farthest_m(result.T_graph_node, begun(graph)), 1);  // there was something to find
}

TEST(PoseGraph, AClosedLoopLosesMostOfItsDrift) {
  PoseGraph graph = driven_round();
  const double before = rms_m(begun(graph));
  graph.edges.push_back(closure(0, 40));
  const PoseGraphResult result = optimise(graph);
  ASSERT_EQ(result.status, PoseGraphStatus::converged);
  EXPECT_GT(before, 1.5);
  EXPECT_LT(rms_m(result.T_graph_node), 0.2 * before);
  EXPECT_GT(result.edge_weight.back(), 0.5);
}

TEST(PoseGraph, TheFixedNodeStaysAndAllElseMovesWithIt) {
  PoseGraph graph = driven_round();
  graph.edges.push_back(closure(0, 40));
  const PoseGraphResult here = optimise(graph);
  EXPECT_EQ(here.T_graph_node[0].matrix(), graph.nodes[0].T_graph_node.matrix());
  const Pose T = pose_from_yaw(1.1, {300, -200, 10});
  for (PoseNode& node : graph.nodes) node.T_graph_node = T * node.T_graph_node;
  const PoseGraphResult there = optimise(graph);
  for (std::size_t i = 0; i < nodes_round; ++i)
    EXPECT_LT((T * here.T_graph_node[i].translation() - there.T_graph_node[i].translation()).norm(), 1e-4) << i;
}

TEST(PoseGraph, OneWrongEdgeHasNoSay) {
  PoseGraph graph = driven_round();
  for (const std::size_t i : {0, 1, 2}) graph.edges.push_back(closure(i, i == 0 ? 40 : 40 - i));
  const double without = rms_m(optimise(graph).T_graph_node);
  graph.edges.push_back(closure(8, 28, Pose(Eigen::Translation3d(6, 4, 0))));
  const PoseGraphResult result = optimise(graph);
  EXPECT_LT(result.edge_weight.back(), 0.01);
  EXPECT_GT(result.edge_weight[40], 0.3);
  EXPECT_LT(rms_m(result.T_graph_node), without + 0.05);
  graph.edges.back().may_be_wrong = false;  // the same edge, believed, is a disaster: the test can fail
  EXPECT_GT(rms_m(optimise(graph).T_graph_node), 3 * without);
}

// A residual of so many sigmas has half its weight: less keeps more, more keeps less.
TEST(PoseGraph, AnEdgeIsHalfBelievedAtTheLimit) {
  const auto weight_at = [](double sigmas) {
    PoseGraph graph;
    graph.nodes = {{Pose::Identity(), true}, {Pose::Identity(), true}};
    graph.edges.push_back({0, 1, Pose(Eigen::Translation3d(sigmas * 0.1, 0, 0)), information_of(0.01, 0.1), true});
    return optimise(graph).edge_weight[0];
  };
  EXPECT_GT(weight_at(3.9), 0.5);
  EXPECT_LT(weight_at(4.1), 0.5);
}

// Along a smooth tunnel a registration says nothing: the node goes where another edge puts it, and not elsewhere.
TEST(PoseGraph, AnOpenDirectionStaysOpen) {
  PoseGraph graph;
  graph.nodes = {{Pose::Identity(), true}, {Pose(Eigen::Translation3d(5, 0, 0))}};
  Matrix6d open = information_of(0.01, 0.05);
  open(3, 3) = 0;  // x
  graph.edges.push_back({0, 1, Pose(Eigen::Translation3d(9, 1, 0)), open, true});
  const Pose alone = optimise(graph).T_graph_node[1];
  EXPECT_NEAR(alone.translation().x(), 5, 1e-6);  // nothing asks it to move
  EXPECT_NEAR(alone.translation().y(), 1, 1e-4);
  graph.edges.push_back({0, 1, Pose(Eigen::Translation3d(5.5, 0, 0)), information_of(10, 1)});
  const PoseGraphResult both = optimise(graph);
  EXPECT_NEAR(both.T_graph_node[1].translation().x(), 5.5, 1e-3);
  EXPECT_NEAR(both.T_graph_node[1].translation().y(), 1, 0.01);
  EXPECT_GT(both.edge_weight[0], 0.9);
}

TEST(PoseGraph, MovingTheFirstGuessChangesNothing) {
  PoseGraph graph = driven_round();
  graph.edges.push_back(closure(0, 40));
  const PoseGraphResult first = optimise(graph);
  std::mt19937_64 random(3);
  std::normal_distribution<double> off(0, 0.2);
  for (std::size_t i = 1; i < nodes_round; ++i)
    graph.nodes[i].T_graph_node.translation() += Eigen::Vector3d(off(random), off(random), off(random));
  EXPECT_LT(farthest_m(first.T_graph_node, optimise(graph).T_graph_node), 2e-3);
}

TEST(PoseGraph, TheSameTwice) {
  PoseGraph graph = driven_round();
  graph.edges.push_back(closure(0, 40));
  const PoseGraphResult first = optimise(graph), again = optimise(graph);
  for (std::size_t i = 0; i < nodes_round; ++i)
    EXPECT_EQ(first.T_graph_node[i].matrix(), again.T_graph_node[i].matrix());
}

// Control points tie keyframes to the mine's grid, which is a node whose place is sought with the others.
TEST(PoseGraph, SurveyedMarksTakeTheDriftOut) {
  PoseGraph graph = driven_round();
  const double before = rms_m(begun(graph));
  const Pose T_grid_graph = pose_from_yaw(0.4, {1000, 2000, 300});
  graph.nodes.push_back({T_grid_graph.inverse() * pose_from_yaw(0.02, {2, -1, 0.5})});
  const std::size_t grid = graph.nodes.size() - 1;
  for (const std::size_t i : {0, 3, 10, 20, 30, 40}) {
    const Eigen::Vector3d p_node(0.5, 1.5, 0.2);
    graph.points.push_back({i, grid, p_node, T_grid_graph * (true_pose(i) * p_node)});
  }
  const PoseGraphResult result = optimise(graph);
  ASSERT_EQ(result.status, PoseGraphStatus::converged);
  const Pose T_surveyed_graph = T_grid_graph.inverse() * result.T_graph_node[grid].inverse();
  std::vector<Pose> surveyed;
  for (std::size_t i = 0; i < nodes_round; ++i) surveyed.push_back(T_surveyed_graph * result.T_graph_node[i]);
  EXPECT_LT(rms_m(surveyed), 0.05 * before);
}

TEST(PoseGraph, GravityHoldsWhatNothingElseDoes) {
  PoseGraph graph;
  graph.nodes = {{Pose::Identity(), true}, {Pose::Identity(), false, Eigen::Vector3d::UnitZ()}};
  Vector6d d = Vector6d::Zero();
  d[0] = 0.05;
  graph.edges.push_back({0, 1, se3_exp(d), information_of(0.05, 0.1)});
  EXPECT_LT(tilt_rad(optimise(graph).T_graph_node[1]), 0.005);
  graph.nodes[1].up.reset();
  EXPECT_NEAR(tilt_rad(optimise(graph).T_graph_node[1]), 0.05, 1e-4);
}

TEST(PoseGraph, WhatIsNotFiniteComesBackAsItCame) {
  PoseGraph graph = driven_round();
  graph.edges[7].information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const PoseGraphResult result = optimise(graph);
  EXPECT_EQ(result.status, PoseGraphStatus::failed);
  EXPECT_EQ(farthest_m(result.T_graph_node, begun(graph)), 0);
  EXPECT_EQ(optimise({}).T_graph_node.size(), 0U);
  graph = driven_round();
  graph.edges.push_back({3, 99, Pose::Identity(), Matrix6d::Identity()});
  EXPECT_THROW((void)optimise(graph), std::out_of_range);
}

}  // namespace
}  // namespace headframe
