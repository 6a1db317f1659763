#pragma once
// What a standby server keeps of stored sessions to search pairs of them.

#include <set>

#include "server/merge/pair_search.hpp"
#include "server/store/database.hpp"

namespace headframe {

/// Reads sessions from the store as the merge pipeline gets them, and searches pairs. Prepared clouds, submaps and wall
/// maps are kept within the limits of MergeConfig, keyframes up to most_keyframes. Not thread safe.
class PairReplica : private CloudSource {
 public:
  static constexpr std::size_t most_keyframes = 100'000;

  PairReplica(const MergeConfig& config, Database& database);

  /// The bytes of what is found. refused: what is stored is not what the task is about; else errors of the database.
  Result<std::string> find(const PairTask& task);

 private:
  struct Known {
    std::set<std::uint64_t> stored;  // clouds
    std::string digest;
  };
  Result<void> bring(SessionId id, std::uint64_t keyframes, bool complete, std::string_view digest);
  Result<void> look_for_clouds(SessionId id);
  Result<void> read_anew(SessionId id, std::uint64_t keyframes, bool complete);
  void forget(SessionId id);
  void forget_others(const PairTask& task);

  CloudState state(const KeyframeRef& keyframe) const override;
  Result<CloudDecoder> load(const KeyframeRef& keyframe) override;

  Database& database_;
  SessionMap sessions_;
  HypothesisFinder finder_;
  SessionSubmaps submaps_;
  CloudRequests requests_;
  SelfSimilarity self_;
  CandidateVerifier verifier_;
  PairSearch search_;
  std::map<SessionId, Known> known_;
};

}  // namespace headframe
