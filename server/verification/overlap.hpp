#pragma once
// The places of an overlap, each registered by itself, as one map: one transform that suits them all.

#include <vector>

#include "server/verification/evidence.hpp"
#include "server/verification/judge_config.hpp"
#include "server/verification/submap_check.hpp"

namespace headframe {

/// A place of the overlap as each session knows it.
struct SubmapPair {
  SubmapPtr a, b;
};

/// Whether the registration says anything.
bool usable(const Registration& registration);

struct Overlap {
  std::vector<VgicpPair> joined;                       // the places that agree
  std::vector<VgicpPair> everywhere;                   // with those that were caught elsewhere along the tunnel
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    // of those that agree, in b's frame
  Eigen::Vector3d weakest = Eigen::Vector3d::UnitX();  // direction in a's frame that holds least
  double weakest_hold = 0;                             // its eigenvalue of the normals' mean outer product
};

/// The pairs must outlive it; at least one must agree.
Overlap overlap_of(const std::vector<SubmapPair>& pairs, const std::vector<SubmapCheck>& places,
                   const std::vector<bool>& agrees);

/// One T for all places that agree: each pulls its p_b to where its own registration put it, as firmly as its points
/// hold each direction, and its rotation as a body of 8 m would.
Pose combine(const std::vector<SubmapCheck>& places, const std::vector<bool>& agrees, const Pose& T_0);

/// All that agree registered at once from T_0: pulls out a slide along a tunnel that each by itself allows. T_0 when
/// that does not converge nearby.
Pose align_overlap(const Overlap& overlap, const Pose& T_0, const JudgeConfig& config);

/// Where a tunnel hardly holds the overlap along its axis, ribs that repeat catch a registration at any period: it is
/// slid to where the surfaces that face along the axis meet, and registered again there. T_a_b itself where it is held,
/// or where nothing meets better elsewhere. end_on_match: Evidence::end_on_match of the answer.
Pose settled(const Overlap& overlap, const Pose& T_a_b, const JudgeConfig& config, double& end_on_match);

}  // namespace headframe
