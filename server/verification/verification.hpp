#pragma once
// From a hypothesis to a transform with evidence: register one place, then places spread over the overlap, each by
// itself; one T that suits them all; then what speaks against it. Verification decides, not the fit alone.

#include <functional>
#include <span>

#include "server/verification/change.hpp"
#include "server/verification/meeting.hpp"
#include "server/verification/screening_result.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {

struct Judgement {
  RegistrationStatus status = RegistrationStatus::too_little_overlap;
  Pose T_a_b = Pose::Identity();     // means nothing unless status is converged or degenerate
  Evidence evidence;                 // probability is set by the verdict; support and runner_up by the caller
  std::vector<Change> changes = {};  // of the mine, that explain what contradicts; in a's frame
};

/// A session as the judge sees it.
struct Scene {
  std::vector<KeyframePosition> positions;  // within look_m of the other session's path, in the order of the session
  std::function<std::vector<SubmapPtr>(std::span<const std::size_t> keyframes)>
      places;  // around each that is asked for
};

/// Goes on from a hopeful result of screening. Pure but for what the scenes do; independent of the thread count.
Judgement judge(const Scene& a, const Scene& b, const ScreeningResult& first, const JudgeConfig& config);

/// Both, trusting T_a_b_0 to within a metre or two: a published alignment looked at again with more keyframes.
Judgement judge_again(const Scene& a, const Scene& b, const Pose& T_a_b_0, const JudgeConfig& config);

/// Sets the probabilities of a judgement from the rest of its evidence.
void weigh(Judgement& judgement);

}  // namespace headframe
