#pragma once
// From a hypothesis to a transform with evidence: register locally, register the whole overlap, then ask what speaks
// against it. Verification decides, not the fit alone.

#include <span>

#include "server/atlas/alignment.hpp"
#include "server/registration/gicp.hpp"
#include "server/registration/submap.hpp"

namespace headframe {

struct JudgeConfig {
  double meet_m = 25;       // keyframes of both sessions nearer than this take part in the registration of the overlap
  double look_m = 35;       // ... and in the evidence
  float view_reach_m = 30;  // free space is checked up to here
  float local_leaf_m = 0.3F;
  float overlap_leaf_m = 0.4F;
  float evidence_leaf_m = 0.5F;
  double hopeless_violation = 0.06;  // more over the whole overlap: not looked at any closer
  std::size_t places = 5;            // where the overlap is registered once more by itself ...
  double place_reach_m = 15;         // ... around keyframes of b that lie this near to one of a's
  double place_radius_m = 18;
  double place_drift_m = 1.5;  // how far a place may move by itself: the drift of both sessions
  double place_drift_rad = 0.07;
  int threads = 1;
};

struct Judgement {
  RegistrationStatus status = RegistrationStatus::too_little_overlap;
  Pose T_a_b = Pose::Identity();  // means nothing unless status is converged or degenerate
  Evidence evidence;              // probability is set by the verdict; support and runner_up by the caller
};

/// Registers b on a from the hypothesis and gathers the evidence. Clouds are all that is there of each session. Pure;
/// independent of the thread count; thread safe.
Judgement judge(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_a_b_0,
                const JudgeConfig& config);

/// The same, trusting T_a_b_0 to within 1.5 m: a published alignment looked at again with more keyframes.
Judgement judge_again(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_a_b_0,
                      const JudgeConfig& config);

/// Probability that T_a_b is right; 0 unless the registration converged or is degenerate.
double probability(RegistrationStatus status, const Evidence& evidence);

}  // namespace headframe
