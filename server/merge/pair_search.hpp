#pragma once
// The expensive part of merging that depends on nothing but two sessions: searching and screening. So it may be
// computed elsewhere, or ahead of time.

#include "server/merge/candidate_verifier.hpp"
#include "server/session/pair_task.hpp"

namespace headframe {

/// What the results depend on beside the sessions: the program (a digest of its file), the C library, the processor and
/// the configuration.
std::string computed_by(const MergeConfig& config);

/// The configuration of the search that follows from that of the pipeline.
HypothesisFinder::Config finder_config(const MergeConfig& config);

/// Searches and screens pairs. Keeps nothing but what its parts keep. Not thread safe.
class PairSearch {
 public:
  PairSearch(const MergeConfig& config, const SessionMap& sessions, HypothesisFinder& finder, SessionSubmaps& submaps,
             const CloudRequests& requests, SelfSimilarity& self, CandidateVerifier& verifier)
      : config_(config),
        judge_(judge_config(config)),
        sessions_(sessions),
        finder_(finder),
        submaps_(submaps),
        requests_(requests),
        self_(self),
        verifier_(verifier) {}

  /// 32 bytes, of all that results depend on of one session: its keyframes as they are in the session map, which of its
  /// clouds are stored, and computed_by().
  std::string digest(SessionId id, const CloudSource& clouds) const;

  /// The sessions must be there, and clouds are not asked for. a == b: how the session looks like itself.
  PairFindings find(SessionId a, SessionId b, CloudSource& clouds);

  static SessionView view(SessionId id, const Session& session);

 private:
  const MergeConfig config_;
  const JudgeConfig judge_;
  const SessionMap& sessions_;
  HypothesisFinder& finder_;
  SessionSubmaps& submaps_;
  const CloudRequests& requests_;
  SelfSimilarity& self_;
  CandidateVerifier& verifier_;
};

}  // namespace headframe
