#pragma once
// The cheap first registration of hypotheses: many are tried, few go on to verification.

#include "server/merge/cloud_requests.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// The configuration of verification that follows from that of the pipeline.
JudgeConfig judge_config(const MergeConfig& config);

/// Registers the first place of each case: all of them coarsely, the likeliest JudgeConfig::screened_fully fully. Runs
/// in parallel; the results, one for each case, do not depend on the number of threads.
std::vector<ScreeningResult> screen(const OrderedPair& pair, const std::vector<Case>& cases, SessionSubmaps& submaps,
                                    CloudSource& clouds, const JudgeConfig& judge);

/// The submaps of the first place of a case, which screen() registered; null where the two sessions do not meet.
SubmapPair first_place(const OrderedPair& pair, const Case& c, SessionSubmaps& submaps, CloudSource& clouds,
                       const JudgeConfig& judge);

/// Sum of likeness() over the placements, counting each distinct one once and leaving out those near `T`; see
/// Evidence::look_alikes.
double look_alikes(std::vector<ScreeningResult> screened, const Pose& T);

}  // namespace headframe
