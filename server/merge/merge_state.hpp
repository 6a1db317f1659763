#pragma once
// The parts of the merge pipeline, each of which owns its state; merge_pipeline.cpp connects them.

#include <set>

#include "server/merge/consistency_check.hpp"
#include "server/merge/corrected_poses.hpp"
#include "server/merge/judged_pairs.hpp"
#include "server/merge/localize.hpp"
#include "server/merge/loop_closures.hpp"
#include "server/merge/merge_pipeline.hpp"
#include "server/merge/pair_work.hpp"
#include "server/merge/partner_promise.hpp"
#include "server/merge/partner_ranking.hpp"

namespace headframe {

struct MergePipeline::State {
  State(const MergeConfig& c, PairHelpers* helpers);

  const MergeConfig config;
  SessionMap sessions;
  PartnerRanking partners;
  HypothesisFinder finder;
  PartnerPromise promise;
  SessionSubmaps submaps;
  CloudRequests requests;
  SelfSimilarity self;
  CandidateVerifier verifier;
  PairSearch search;
  PairWork shared;  // searches that other servers may have made
  JudgedPairs judged;
  AlignmentBook book;
  LoopClosures closures;
  CorrectedPoses corrected;
  ConsistencyCheck consistency;
  std::set<std::pair<SessionId, SessionId>> to_settle;  // recently published
  std::set<SessionId> to_prepare;  // sessions with news, for which something can be computed ahead of attempts

  /// Whether a look at the likeliest placements decides if the others of a pair are looked at.
  enum class Look { at_all, at_the_likeliest_first };
  void merge_pair(const OrderedPair& pair, const Attempt& attempt, Look look = Look::at_all);
  Verdicts judge_cases(const OrderedPair& pair, const std::vector<Case>& cases, const Alignment* known,
                       const PairFindings* found_elsewhere, const Attempt& attempt, Look look);
  void merge_with_partners(SessionId id, const Attempt& attempt);
  std::vector<SessionId> most_promising(SessionId id, std::vector<SessionId> ranked, AttemptReport& report);
  void settle_others(SessionId id, const Attempt& attempt);
  const Found* propose(const OrderedPair& pair, AttemptReport& report, std::optional<PairFindings> known = {});
  std::optional<PairFindings> found_elsewhere(const OrderedPair& pair, const Attempt& attempt);
  void announce(SessionId id, const std::vector<SessionId>& ranked, int in_vain, const CloudSource& clouds);
  std::vector<OrderedPair> searches_of(SessionId id, const std::vector<SessionId>& ranked, int in_vain,
                                       const CloudSource& clouds) const;
  std::vector<Verdict> judge_by_hand(const OrderedPair& pair, const Case& at, const Attempt& attempt);
  bool still_holds(const OrderedPair& pair, Alignment& published, const Attempt& attempt);
  JudgedOn what_there_is(const OrderedPair& pair, const Found& found, const std::vector<Case>& cases) const;
  bool ended_since_judged(const Alignment& known) const;
  void drop_ruled_out(const OrderedPair& pair, const Alignment& known, std::vector<Verdict>& verdicts) const;
  void update_atlas(AttemptReport& report);
  void forget_what_was_made_of(SessionId id);
  void close_loops(SessionId id, const Attempt& attempt);
};

}  // namespace headframe
