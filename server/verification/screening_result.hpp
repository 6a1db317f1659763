#pragma once
// The first registration of a hypothesis, at one place of the overlap: cheap, and enough to drop most.

#include "server/verification/evidence.hpp"
#include "server/verification/judge_config.hpp"
#include "server/verification/submap_check.hpp"

namespace headframe {

/// What the first registration of a hypothesis came to.
struct ScreeningResult {
  bool hopeful = false;  // worth a judgement; else `place` may be empty
  SubmapCheck place;     // registered, and looked through
  SubmapPtr a, b;        // the submaps of the place
};

/// Share of b's points that match (Matched::cautious) after a short, coarse registration from T_a_b_0, which becomes
/// where that ended; 0 when it went astray. A tenth of the work of screen_submaps(), to tell which of many are worth
/// it. Pure.
double coarse_fit(const Submap& a, const Submap& b, Pose& T_a_b_0);

/// Registers the first place of a hypothesis from T_a_b_0, and looks through its free space. Pure, thread safe.
ScreeningResult screen_submaps(const SubmapPtr& a, const SubmapPtr& b, const Pose& T_a_b_0, const JudgeConfig& config);

/// How far the first place, taken alone, fits as a copy of the rock would, 0 to 1: most points meet, surfaces lie on
/// each other, next to nothing contradicts, and nothing slides.
double likeness(const ScreeningResult& result);

/// Whether the first place, taken alone, looks right. Where other placements do too, the mine repeats itself there.
bool fits_alone(const ScreeningResult& result);

/// Probability that would be left to a placement with this result, and with what `known` says of its descriptors, if
/// all else spoke for it: more than judge() can give.
double best_probability(const ScreeningResult& result, const Evidence& known = {});

}  // namespace headframe
