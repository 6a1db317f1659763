#pragma once
// The first registration of a hypothesis, at one place of the overlap: cheap, and sufficient to drop most hypotheses.

#include "server/verification/evidence.hpp"
#include "server/verification/judge_config.hpp"
#include "server/verification/submap_check.hpp"

namespace headframe {

/// The result of the first registration of a hypothesis.
struct ScreeningResult {
  bool hopeful = false;  // worth judging; if false, `place` may be empty
  SubmapCheck place;     // registered, with its free space checked
  SubmapPtr a, b;        // the submaps of the place
};

/// Refines T_a_b_0 by a short, coarse registration and returns the share of b's points that match there
/// (Matched::cautious); 0 if it diverged. Takes a tenth of the time of screen_submaps(), to choose the hypotheses that
/// deserve it. Pure.
double coarse_fit(const Submap& a, const Submap& b, Pose& T_a_b_0);

/// Registers the first place of a hypothesis from T_a_b_0 and checks its free space. Pure, thread safe.
ScreeningResult screen_submaps(const SubmapPtr& a, const SubmapPtr& b, const Pose& T_a_b_0, const JudgeConfig& config);

/// How well the first place, taken alone, fits as a copy of the rock would, 0 to 1: most points match, surfaces
/// coincide, next to nothing contradicts (fully up to .1 % of the points, not from .4 % on), and the placement cannot
/// slide.
double likeness(const ScreeningResult& result);

/// The same where up to 1.2 % of the points contradict (fully up to .05 %). Not a copy, but a sign that the mine may
/// hold some.
double resemblance(const ScreeningResult& result);

/// Whether the first place, taken alone, looks right. If it does for several placements, the mine repeats itself there.
/// Less than .2 % of its points may be contradicted: at three of four places where a session of the two worlds of equal
/// tunnels resembles itself .04 % are at most; in a cave, a surveyed mine and rough tunnels .33 % and more.
bool fits_alone(const ScreeningResult& result);

/// Evidence that could not be better.
Evidence ideal_evidence();

/// The probability that judge() could give to a placement with this screening result, if everything else that the
/// verdict weighs were as in `best`.
double best_probability(const ScreeningResult& result, Evidence best = ideal_evidence());

}  // namespace headframe
