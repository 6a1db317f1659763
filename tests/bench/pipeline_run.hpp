#pragma once

#include <set>
#include <vector>

#include "server/merge/merge_pipeline.hpp"
#include "tests/bench/driven_session.hpp"

namespace headframe::bench {

/// How robots give their clouds.
enum class Clouds { at_once, on_request };

/// Sessions, numbered from 1 in the order they were added.
class PipelineRun : private CloudSource {
 public:
  explicit PipelineRun(Clouds clouds = Clouds::at_once) : pipeline({}), clouds_(clouds) {}

  /// The session must outlive the run. Its clouds are prepared as they are when they arrive at a server.
  SessionId add(const DrivenSession& session);
  /// The same without its keyframes, which follow one by one: as of a robot that drives.
  SessionId begin(const DrivenSession& session);
  void add_keyframe(SessionId id, std::size_t i);
  /// All sessions so far were tried before, as those that a server finds in its database at its start.
  void take_as_tried() { pipeline.restore({}, 0); }
  /// Attempts until there is nothing more to try, and gives the clouds that are wanted; the times of all together.
  StageTimes attempt(SessionId id);
  /// The verdict when it is handed this placement; a < b.
  Judgement judge(SessionId a, SessionId b, const Pose& T_a_b) { return pipeline.judge_placement(a, b, T_a_b, *this); }
  std::size_t came() const { return came_.size(); }  // of clouds on request

  MergePipeline pipeline;
  std::vector<PairTrace> traces;  // of all attempts
  std::map<std::pair<SessionId, SessionId>, PoseConstraints> closures;
  std::vector<const DrivenSession*> sessions;
  const DrivenSession& session(SessionId id) const { return *sessions.at(static_cast<std::size_t>(id - 1)); }

 private:
  CloudState state(const KeyframeRef& keyframe) const override;
  Result<CloudDecoder> load(const KeyframeRef& keyframe) override;

  Clouds clouds_;
  std::set<KeyframeRef> came_;
};

/// What became of a pair, against the truth.
struct Outcome {
  bool merged = false;  // there is a published alignment between them
  bool right = false;   // ... within 1 m and 3 deg near the overlap
  test::OverlapError error;
};
Outcome judge_outcome(const PipelineRun& run, SessionId a, SessionId b);

}  // namespace headframe::bench
