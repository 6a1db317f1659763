#include "server/atlas/pose_constraint.hpp"

namespace headframe {

PoseConstraint constraint_between(const KeyframeRef& from, const Pose& T_a_from, const KeyframeRef& to,
                                  const Pose& T_b_to, const PlaceFit& fit) {
  const Pose T_a_to = fit.T_a_b * T_b_to;
  // A step (w', v') in the frame of `to` turns by w = R w' and moves what lies at `about` by R v' + (o - c) x w.
  const Eigen::Matrix3d& R = T_a_to.linear();
  Matrix6d step = Matrix6d::Zero();
  step.topLeftCorner<3, 3>() = step.bottomRightCorner<3, 3>() = R;
  step.bottomLeftCorner<3, 3>() = skew(T_a_to.translation() - fit.about) * R;
  return {from, to, T_a_from.inverse() * T_a_to, step.transpose() * fit.information * step};
}

}  // namespace headframe
