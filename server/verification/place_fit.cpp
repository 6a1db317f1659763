#include "server/verification/place_fit.hpp"

#include <Eigen/Eigenvalues>

#include "server/verification/evidence.hpp"

namespace headframe {
namespace {

/// Takes one direction out: the information that is left says nothing of a step along it.
void leave_open(Matrix6d& information, const Vector6d& direction) {
  const Matrix6d rest = Matrix6d::Identity() - direction * direction.transpose();
  information = (rest * information * rest).eval();
}

}  // namespace

PlaceFit place_fit(const Registration& registration) {
  PlaceFit fit{registration.T_target_source, registration.centre, registration.information};
  const double trace = fit.information.bottomRightCorner<3, 3>().trace();
  if (!(trace > 0)) {
    fit.information.setZero();
    return fit;
  }
  fit.information *= 3 / (trace * place_sigma_m * place_sigma_m);
  for (const FreeDirection& free : registration.free_directions) {
    if (free.kind != FreeDirection::Kind::rotation) continue;
    Vector6d turn = Vector6d::Zero();
    turn.head<3>() = free.axis;
    leave_open(fit.information, turn);
  }
  const Matrix6d held = fit.information;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(held.bottomRightCorner<3, 3>());
  const double all = eigen.eigenvalues().sum();
  const Eigen::Vector3d doubted = (3 / all * eigen.eigenvalues()).cwiseMax(0).cwiseMin(1).cwiseSqrt();
  Matrix6d scale = Matrix6d::Identity();
  scale.bottomRightCorner<3, 3>() = eigen.eigenvectors() * doubted.asDiagonal() * eigen.eigenvectors().transpose();
  fit.information = scale * fit.information * scale;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] >= held_well * all) continue;
    Vector6d slide = Vector6d::Zero();
    slide.tail<3>() = eigen.eigenvectors().col(i);
    leave_open(fit.information, slide);
  }
  return fit;
}

}  // namespace headframe
