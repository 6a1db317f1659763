#pragma once
// A measurement between two keyframes besides odometry: a loop closure.

#include <memory>
#include <vector>

#include "server/session/ids.hpp"
#include "server/verification/place_fit.hpp"

namespace headframe {

/// Like PoseEdge, but between the sensor frames of two keyframes, so it holds in any frame of their sessions.
struct PoseConstraint {
  KeyframeRef from, to;
  Pose T_from_to = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  // of T_from_to * se3_exp(d), rotation first (1/rad^2, 1/m^2)

  bool operator==(const PoseConstraint& other) const {
    return from == other.from && to == other.to && T_from_to.matrix() == other.T_from_to.matrix() &&
           information == other.information;
  }
};

/// Immutable and shared: alignments are copied often.
using PoseConstraints = std::shared_ptr<const std::vector<PoseConstraint>>;

/// All loop closures between two sessions, from a to b, or within one session (a == b).
struct PairClosures {
  SessionId a = 0, b = 0;
  PoseConstraints places;
};

/// Converts a fit between the frames of two sessions.
PoseConstraint constraint_between(const KeyframeRef& from, const Pose& T_a_from, const KeyframeRef& to,
                                  const Pose& T_b_to, const PlaceFit& fit);

}  // namespace headframe
