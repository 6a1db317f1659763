#pragma once
// The cheap first registration of hypotheses: many are tried, few go on to verification.

#include "server/merge/cloud_requests.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// The configuration of verification that follows from that of the pipeline.
JudgeConfig judge_config(const MergeConfig& config);

/// Registers the first place of each case: all of them coarsely, the likeliest JudgeConfig::screened_fully fully. The
/// cases before the first that is hopeful then, eight at most, are registered at two further places, because one place
/// may say nothing. Runs in parallel; the results, one for each case, do not depend on the number of threads.
std::vector<ScreeningResult> screen(const OrderedPair& pair, const std::vector<Case>& cases, SessionSubmaps& submaps,
                                    CloudSource& clouds, const JudgeConfig& judge);

/// The submaps of the place of a case that screen() registered; null if its clouds are no longer stored.
SubmapPair place_screened(const OrderedPair& pair, const Case& c, const SubmapCheck& place, SessionSubmaps& submaps,
                          CloudSource& clouds, const JudgeConfig& judge);

/// Sum of `alike`, likeness or resemblance, over the placements, counting each distinct one once and leaving out those
/// near `T`; see Evidence::look_alikes and similar_places.
double count_alike(std::vector<ScreeningResult> screened, const Pose& T, double (*alike)(const ScreeningResult&));

}  // namespace headframe
