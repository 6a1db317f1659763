#pragma once
// Least squares over poses: what is known of pairs of them, and where they lie best. Pure.

#include <cstddef>
#include <optional>
#include <vector>

#include "server/registration/registration.hpp"

namespace headframe {

/// A pose that is sought, T_graph_node.
struct PoseNode {
  Pose T_graph_node = Pose::Identity();  // where the search begins
  bool fixed = false;
  std::optional<Eigen::Vector3d> up = std::nullopt;  // against gravity, a unit vector in the node's frame
};

/// What was measured between two nodes. Information is that of an increment d on the right, T_from_to * se3_exp(d),
/// rotation first (1/rad^2, 1/m^2); a direction without information stays open.
struct PoseEdge {
  std::size_t from = 0, to = 0;
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Identity();
  bool may_be_wrong = false;  // it loses its weight where the others contradict it
};

/// Of a pose that is known so well in every direction.
Matrix6d information_of(double sigma_rad, double sigma_m);

/// One point as two nodes know it: a survey's mark, of a keyframe and of the mine's grid.
struct PointEdge {
  std::size_t a = 0, b = 0;
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero(), p_b = Eigen::Vector3d::Zero();
  double sigma_m = 0.02;  // of each axis
  bool may_be_wrong = true;
};

struct PoseGraph {
  std::vector<PoseNode> nodes;
  std::vector<PoseEdge> edges;
  std::vector<PointEdge> points = {};
};

struct PoseGraphConfig {
  double up_sigma_rad = 0.01;  // of PoseNode::up
  double outlier_sigmas = 4;   // a residual so long has half its weight
  int iterations = 30;         // at most, of each of the three rounds
};

enum class PoseGraphStatus {
  converged,
  not_converged,  // the last round ran out of iterations; poses are as good as they came
  failed          // not finite, or no step could be made: the poses are those that came in
};

struct PoseGraphResult {
  PoseGraphStatus status = PoseGraphStatus::failed;
  std::vector<Pose> T_graph_node;   // of every node
  std::vector<double> edge_weight;  // 1: as its information says; near 0: the others contradict it
  int iterations = 0;               // of all rounds
};

/// The poses with the least sum of squared residuals, by Levenberg and Marquardt over a sparse Cholesky factor (Ceres).
/// Edges that may be wrong have Cauchy's kernel, whose scale comes down in three rounds (Yang et al., "Graduated
/// Non-Convexity for Robust Spatial Perception", 2020). Nodes that nothing holds stay about where they were.
/// Deterministic: one thread. Throws Cancelled (support/parallel.hpp), and std::out_of_range where an edge names no
/// node.
PoseGraphResult optimise(const PoseGraph& graph, const PoseGraphConfig& config = {});

}  // namespace headframe
