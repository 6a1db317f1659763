#pragma once
// The cheap first registration of hypotheses: many are looked at, few go on.

#include "server/merge/cloud_requests.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// What verification is configured with, on this server.
JudgeConfig judge_config(const MergeConfig& config);

/// Registers the first place of each case: coarsely all of them, fully the likeliest JudgeConfig::screened_fully. In
/// parallel; the results, one a case, do not depend on the number of threads.
std::vector<ScreeningResult> screen(const OrderedPair& pair, const std::vector<Case>& cases, SessionSubmaps& submaps,
                                    CloudSource& clouds, const JudgeConfig& judge);

/// Sum of the likeness of these, each placement once and those near `T` left out; see Evidence::look_alikes.
double look_alikes(std::vector<ScreeningResult> screened, const Pose& T);

}  // namespace headframe
