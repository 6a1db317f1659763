#pragma once

#include <map>
#include <vector>

#include "server/merge_pipeline.hpp"
#include "tests/bench/driven_session.hpp"

namespace headframe::bench {

/// Sessions with all their clouds at hand, numbered from 1 in the order they were added.
class PipelineRun : private CloudSource {
 public:
  explicit PipelineRun(const MergeConfig& config = {}) : pipeline(config) {}

  /// The session must outlive the run. Its clouds are prepared as they are when they arrive at a server.
  SessionId add(const DrivenSession& session);
  /// Attempts until there is nothing more to try; the times of all of them together.
  StageTimes attempt(SessionId id);

  MergePipeline pipeline;
  std::vector<const DrivenSession*> sessions;
  const DrivenSession& session(SessionId id) const { return *sessions.at(static_cast<std::size_t>(id - 1)); }

 private:
  CloudState state(const KeyframeRef& keyframe) const override;
  Result<KeyframeCloud> load(const KeyframeRef& keyframe) override;
};

/// What became of a pair, against the truth.
struct Outcome {
  bool merged = false;  // there is a published alignment between them
  bool right = false;   // ... within 1 m and 3 deg near the overlap
  test::OverlapError error;
};
Outcome judge_outcome(const PipelineRun& run, SessionId a, SessionId b);

}  // namespace headframe::bench
