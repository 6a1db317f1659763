#pragma once
// From a hypothesis to a transform with evidence: register one place, then places spread over the overlap, each
// independently; find one transform for all of them; then look for contradictions. A good fit alone decides nothing.

#include <functional>
#include <span>

#include "server/verification/change.hpp"
#include "server/verification/meeting.hpp"
#include "server/verification/screening_result.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {

struct Judgement {
  RegistrationStatus status = RegistrationStatus::too_little_overlap;
  Pose T_a_b = Pose::Identity();     // valid only if status is converged or degenerate
  Evidence evidence;                 // probability is set by the verdict; support and runner_up by the caller
  std::vector<Change> changes = {};  // of the mine, which explain contradictions; in a's frame
};

/// Two sessions as input of the verification.
struct Scene {
  std::vector<KeyframePosition> a, b;  // within look_m of the other session's path, in the order of the session
  std::function<std::vector<SubmapPair>(std::span<const Meeting>)> places;  // the submaps around these keyframes
};

/// Continues from a promising screening result. Pure, apart from what the scene does; independent of the thread count.
Judgement judge(const Scene& scene, const ScreeningResult& first, const JudgeConfig& config);

/// Screens and judges a placement that is known to within a metre or two: a published alignment with more keyframes.
Judgement judge_again(const Scene& scene, const Pose& T_a_b_0, const JudgeConfig& config);

/// The share of violated points at the worst place of the overlap if nothing is registered; 0 if the two do not meet.
/// Where two sessions share little rock, a registration may go astray by more than the placement that it began with.
double violation_at(const Scene& scene, const Pose& T_a_b, const JudgeConfig& config);

/// Sets the probabilities of a judgement from its other evidence.
void weigh(Judgement& judgement);

/// How probable the placement would be if both sessions had seen any amount of rock.
double probability_with_ample_rock(const Judgement& judgement);

}  // namespace headframe
