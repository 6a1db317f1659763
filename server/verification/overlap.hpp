#pragma once
// Combines the places of an overlap, each registered independently, into one transform.

#include <vector>

#include "server/verification/evidence.hpp"
#include "server/verification/judge_config.hpp"
#include "server/verification/submap_check.hpp"

namespace headframe {

/// Whether the registration succeeded well enough to be used.
bool usable(const Registration& registration);

struct Overlap {
  std::vector<VgicpPair> joined;                       // the places that agree
  std::vector<VgicpPair> everywhere;                   // all usable places, also any that slid along the tunnel
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    // of the agreeing places, in b's frame
  Eigen::Vector3d weakest = Eigen::Vector3d::UnitX();  // direction in a's frame in which it is held least
  double weakest_hold = 0;                             // its eigenvalue of the normals' mean outer product
};

/// The pairs must outlive the result; at least one must agree.
Overlap overlap_of(const std::vector<SubmapPair>& pairs, const std::vector<SubmapCheck>& places,
                   const std::vector<bool>& agrees);

/// One transform for all agreeing places. Each place pulls its p_b to where its own registration put it, weighted in
/// each direction by its surfaces, and pulls the rotation as a body 8 m in size would.
Pose combine(const std::vector<SubmapCheck>& places, const std::vector<bool>& agrees, const Pose& T_0);

/// Registers all agreeing places together from T_0; that removes a slide along a tunnel that each place alone allows.
/// Returns T_0 if the registration does not converge nearby.
Pose align_overlap(const Overlap& overlap, const Pose& T_0, const JudgeConfig& config);

/// Corrects a slide along a tunnel. Where the walls hardly hold the placement along its axis, repeating ribs let a
/// registration lock in at any period. So the overlap is slid to where the surfaces that face along the axis match, and
/// registered again there. Returns T_a_b itself if the placement is held, or if nothing matches better elsewhere.
/// end_on_match: Evidence::end_on_match of the result.
Pose settled(const Overlap& overlap, const Pose& T_a_b, const JudgeConfig& config, double& end_on_match);

}  // namespace headframe
