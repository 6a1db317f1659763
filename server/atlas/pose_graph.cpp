#include "server/atlas/pose_graph.hpp"

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Quaternion = Eigen::Quaternion<T>;

/// As Ceres holds a pose: a quaternion x, y, z, w and a translation.
struct Parameters {
  std::array<double, 4> q;
  std::array<double, 3> t;

  explicit Parameters(const Pose& T) {
    Eigen::Map<Eigen::Quaterniond>(q.data()) = Eigen::Quaterniond(T.rotation()).normalized();
    Eigen::Map<Eigen::Vector3d>(t.data()) = T.translation();
  }
  Pose pose() const {
    Pose T = Pose::Identity();
    T.linear() = Eigen::Map<const Eigen::Quaterniond>(q.data()).normalized().toRotationMatrix();
    T.translation() = Eigen::Map<const Eigen::Vector3d>(t.data());
    return T;
  }
};

template <class T>
Vector3<T> translation(const T* t) {
  return Eigen::Map<const Vector3<T>>(t);
}
template <class T>
Quaternion<T> rotation(const T* q) {
  return Eigen::Map<const Quaternion<T>>(q);
}

/// sqrt(information) * d, where T_from_to * se3_exp(d) is what the poses say: to first order, twice the vector part of
/// the quaternion for the rotation.
struct EdgeResidual {
  Eigen::Quaterniond q_to_from;
  Eigen::Vector3d t_from_to;
  Matrix6d root;

  explicit EdgeResidual(const PoseEdge& edge)
      : q_to_from(Eigen::Quaterniond(edge.T_from_to.rotation()).inverse()), t_from_to(edge.T_from_to.translation()) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(edge.information);
    root = eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  }

  template <class T>
  bool operator()(const T* q_a, const T* t_a, const T* q_b, const T* t_b, T* residuals) const {
    const Quaternion<T> q_a_graph = rotation(q_a).conjugate();
    const Vector3<T> moved = q_a_graph * (translation(t_b) - translation(t_a));
    Quaternion<T> turn = q_to_from.cast<T>() * (q_a_graph * rotation(q_b));
    if (turn.w() < T(0)) turn.coeffs() = -turn.coeffs();
    Eigen::Matrix<T, 6, 1> d;
    d.template head<3>() = T(2) * turn.vec();
    d.template tail<3>() = q_to_from.cast<T>() * (moved - t_from_to.cast<T>());
    Eigen::Map<Eigen::Matrix<T, 6, 1>>(residuals, 6) = root.cast<T>() * d;
    return true;
  }
};

struct PointResidual {
  Eigen::Vector3d p_a, p_b;
  double per_m;

  template <class T>
  bool operator()(const T* q_a, const T* t_a, const T* q_b, const T* t_b, T* residuals) const {
    const Vector3<T> of_a = rotation(q_a) * p_a.cast<T>() + translation(t_a);
    const Vector3<T> of_b = rotation(q_b) * p_b.cast<T>() + translation(t_b);
    Eigen::Map<Vector3<T>>(residuals, 3) = (of_a - of_b) * T(per_m);
    return true;
  }
};

struct UpResidual {
  Eigen::Vector3d up;
  double per_rad;

  template <class T>
  bool operator()(const T* q, T* residuals) const {
    const Vector3<T> z = rotation(q) * up.cast<T>();
    residuals[0] = z.x() * T(per_rad);
    residuals[1] = z.y() * T(per_rad);
    return true;
  }
};

/// Ends the rounds once nobody waits for them any more.
class WhileWanted : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return cancelled() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }
  bool cancelled() const { return flag_ != nullptr && *flag_; }

 private:
  const std::atomic<bool>* const flag_ = Cancellable::flag();
};

class LeastSquares {
 public:
  LeastSquares(const PoseGraph& graph, const PoseGraphConfig& config) : config_(config), graph_(graph) {
    nodes_.reserve(graph.nodes.size());
    for (const PoseNode& node : graph.nodes) add(node);
    for (const PoseEdge& edge : graph.edges) {
      Parameters &a = nodes_.at(edge.from), &b = nodes_.at(edge.to);
      edges_.push_back(problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<EdgeResidual, 6, 4, 3, 4, 3>(new EdgeResidual(edge)),
          edge.may_be_wrong ? &kernel_ : nullptr, a.q.data(), a.t.data(), b.q.data(), b.t.data()));
    }
    for (const PointEdge& point : graph.points) {
      Parameters &a = nodes_.at(point.a), &b = nodes_.at(point.b);
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PointResidual, 3, 4, 3, 4, 3>(
                                    new PointResidual{point.p_a, point.p_b, 1 / point.sigma_m}),
                                point.may_be_wrong ? &kernel_ : nullptr, a.q.data(), a.t.data(), b.q.data(),
                                b.t.data());
    }
  }

  PoseGraphResult solve() {
    PoseGraphResult out;
    constexpr std::array wider{25.0, 5.0, 1.0};  // of the kernel, round by round
    for (const double times : wider) {
      kernel_.Reset(new ceres::CauchyLoss(times * config_.outlier_sigmas), ceres::TAKE_OWNERSHIP);
      out.status = round(out);
      if (out.status == PoseGraphStatus::failed) break;
      if (!robust_) break;  // the rounds do not differ
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      out.T_graph_node.push_back(out.status == PoseGraphStatus::failed ? graph_.nodes[i].T_graph_node
                                                                       : nodes_[i].pose());
    weigh(out);
    return out;
  }

 private:
  /// The problem takes the residuals, and leaves kernel and manifold to this.
  static ceres::Problem::Options lent() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  void add(const PoseNode& node) {
    Parameters& p = nodes_.emplace_back(node.T_graph_node);
    problem_.AddParameterBlock(p.q.data(), 4, &on_sphere_);
    problem_.AddParameterBlock(p.t.data(), 3);
    if (node.fixed) {
      problem_.SetParameterBlockConstant(p.q.data());
      problem_.SetParameterBlockConstant(p.t.data());
    } else if (node.up) {
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<UpResidual, 2, 4>(new UpResidual{*node.up, 1 / config_.up_sigma_rad}),
          nullptr, p.q.data());
    }
  }

  PoseGraphStatus round(PoseGraphResult& out) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = config_.iterations;
    options.function_tolerance = 1e-8;
    options.parameter_tolerance = 1e-9;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    WhileWanted wanted;
    options.callbacks.push_back(&wanted);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (wanted.cancelled()) throw Cancelled();
    out.iterations += static_cast<int>(summary.iterations.size());
    if (!summary.IsSolutionUsable()) return PoseGraphStatus::failed;
    return summary.termination_type == ceres::CONVERGENCE ? PoseGraphStatus::converged : PoseGraphStatus::not_converged;
  }

  void weigh(PoseGraphResult& out) {
    const double scale2 = config_.outlier_sigmas * config_.outlier_sigmas;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      double half_squared = 0;
      problem_.EvaluateResidualBlock(edges_[i], false, &half_squared, nullptr, nullptr);
      out.edge_weight.push_back(graph_.edges[i].may_be_wrong ? 1 / (1 + 2 * half_squared / scale2) : 1);
    }
  }

  const PoseGraphConfig config_;
  const PoseGraph& graph_;
  const bool robust_ =
      std::any_of(graph_.edges.begin(), graph_.edges.end(), [](const PoseEdge& e) { return e.may_be_wrong; }) ||
      std::any_of(graph_.points.begin(), graph_.points.end(), [](const PointEdge& e) { return e.may_be_wrong; });
  std::vector<Parameters> nodes_;  // never moves: the problem points into it
  std::vector<ceres::ResidualBlockId> edges_;
  ceres::EigenQuaternionManifold on_sphere_;
  ceres::LossFunctionWrapper kernel_{new ceres::CauchyLoss(1), ceres::TAKE_OWNERSHIP};
  ceres::Problem problem_{lent()};
};

bool finite(const PoseGraph& graph) {
  return std::all_of(graph.nodes.begin(), graph.nodes.end(),
                     [](const PoseNode& n) { return n.T_graph_node.matrix().allFinite(); }) &&
         std::all_of(graph.edges.begin(), graph.edges.end(),
                     [](const PoseEdge& e) { return e.T_from_to.matrix().allFinite() && e.information.allFinite(); }) &&
         std::all_of(graph.points.begin(), graph.points.end(),
                     [](const PointEdge& p) { return p.p_a.allFinite() && p.p_b.allFinite() && p.sigma_m > 0; });
}

PoseGraphResult as_it_came(const PoseGraph& graph) {
  PoseGraphResult out;
  for (const PoseNode& node : graph.nodes) out.T_graph_node.push_back(node.T_graph_node);
  out.edge_weight.assign(graph.edges.size(), 1);
  return out;
}

}  // namespace

Matrix6d information_of(double sigma_rad, double sigma_m) {
  Vector6d d;
  d.head<3>().setConstant(1 / (sigma_rad * sigma_rad));
  d.tail<3>().setConstant(1 / (sigma_m * sigma_m));
  return d.asDiagonal();
}

PoseGraphResult optimise(const PoseGraph& graph, const PoseGraphConfig& config) {
  if (!finite(graph)) return as_it_came(graph);
  return LeastSquares(graph, config).solve();
}

}  // namespace headframe
