#pragma once
// Pose graph optimisation: finds the poses that best fit measurements between pairs of them. Pure.

#include <cstddef>
#include <optional>
#include <vector>

#include "server/registration/registration.hpp"

namespace headframe {

/// An unknown pose, T_graph_node.
struct PoseNode {
  Pose T_graph_node = Pose::Identity();  // initial value
  bool fixed = false;
  std::optional<Eigen::Vector3d> up = std::nullopt;  // against gravity, a unit vector in the node's frame
};

/// A measurement between two nodes. The information is that of a right increment d, T_from_to * se3_exp(d), rotation
/// first (1/rad^2, 1/m^2); a direction without information is not constrained.
struct PoseEdge {
  std::size_t from = 0, to = 0;
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Identity();
  bool may_be_wrong = false;  // it loses weight if other measurements contradict it
};

/// The information of a pose with these standard deviations on every axis.
Matrix6d information_of(double sigma_rad, double sigma_m);

/// One point known in two nodes' frames: a survey mark, in a keyframe's and in the mine grid's.
struct PointEdge {
  std::size_t a = 0, b = 0;
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero(), p_b = Eigen::Vector3d::Zero();
  double sigma_m = 0.02;  // on each axis
  bool may_be_wrong = true;
};

struct PoseGraph {
  std::vector<PoseNode> nodes;
  std::vector<PoseEdge> edges;
  std::vector<PointEdge> points = {};
};

struct PoseGraphConfig {
  double up_sigma_rad = 0.01;  // of PoseNode::up
  double outlier_sigmas = 4;   // residual at which an edge has half its weight
  int iterations = 30;         // at most, in each of the three rounds
};

enum class PoseGraphStatus {
  converged,
  not_converged,  // the last round ran out of iterations; the poses are those reached so far
  failed          // not finite, or no step was possible; the poses are the initial ones
};

struct PoseGraphResult {
  PoseGraphStatus status = PoseGraphStatus::failed;
  std::vector<Pose> T_graph_node;   // of every node
  std::vector<double> edge_weight;  // 1: full weight; near 0: other measurements contradict the edge
  int iterations = 0;               // of all rounds
};

/// Minimises the sum of squared residuals by Levenberg-Marquardt with a sparse Cholesky factorisation (Ceres). Edges
/// that may be wrong get a Cauchy kernel whose scale shrinks over three rounds (Yang et al., "Graduated Non-Convexity
/// for Robust Spatial Perception", 2020). Nodes that nothing constrains stay close to where they were. Deterministic:
/// one thread. Throws Cancelled (support/parallel.hpp), and std::out_of_range if an edge names a node that does not
/// exist.
PoseGraphResult optimise(const PoseGraph& graph, const PoseGraphConfig& config = {});

}  // namespace headframe
