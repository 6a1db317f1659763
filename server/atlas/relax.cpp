#include "server/atlas/relax.hpp"

#include <Eigen/Cholesky>

namespace headframe {

void relax(Frames& frames, const std::vector<Alignment>& edges) {
  std::map<SessionId, Eigen::Index> column;
  for (const auto& [session, T] : frames) column[session] = 6 * (static_cast<Eigen::Index>(column.size()) - 1);
  const Eigen::Index n = 6 * (static_cast<Eigen::Index>(frames.size()) - 1);
  Vector6d weight;
  weight << 400, 400, 400, 1, 1, 1;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    for (const Alignment& edge : edges) {
      // r = log(T_a_b^-1 T_a^-1 T_b); right increments: T_b moves r by d_b, T_a by -Ad(T_b^-1 T_a) d_a, to first order.
      const Pose T_b_a = frames[edge.b].inverse() * frames[edge.a];
      const Vector6d r = se3_log(edge.T_a_b.inverse() * T_b_a.inverse());
      Eigen::Matrix<double, 6, 6> J_a = Eigen::Matrix<double, 6, 6>::Zero();
      J_a.topLeftCorner<3, 3>() = J_a.bottomRightCorner<3, 3>() = -T_b_a.linear();
      J_a.bottomLeftCorner<3, 3>() = -skew(T_b_a.translation()) * T_b_a.linear();
      const Eigen::Index a = column[edge.a], b = column[edge.b];
      const Eigen::Matrix<double, 6, 6> W = weight.asDiagonal();
      if (a >= 0) {
        H.block<6, 6>(a, a) += J_a.transpose() * W * J_a;
        g.segment<6>(a) += J_a.transpose() * W * r;
      }
      if (b >= 0) {
        H.block<6, 6>(b, b) += W;
        g.segment<6>(b) += W * r;
      }
      if (a >= 0 && b >= 0) {
        H.block<6, 6>(a, b) += J_a.transpose() * W;
        H.block<6, 6>(b, a) += W * J_a;
      }
    }
    H.diagonal().array() += 1e-9;
    const Eigen::VectorXd d = -H.ldlt().solve(g);
    for (auto& [session, T] : frames)
      if (column[session] >= 0) T = orthonormalised(T * se3_exp(d.segment<6>(column[session])));
    if (d.norm() < 1e-9) break;
  }
}

}  // namespace headframe
