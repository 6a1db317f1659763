#pragma once

#include <memory>

#include "server/merge/merge_pipeline.hpp"

namespace headframe {

/// The interface of MergePipeline that the worker uses, so that tests can replace it. See merge_pipeline.hpp.
class Pipeline {
 public:
  virtual ~Pipeline() = default;
  virtual void add_session(SessionId id, const FamilyId& family, const std::string& site) = 0;
  virtual void add_keyframe(SessionId id, Keyframe keyframe) = 0;
  virtual void prepare_cloud(const KeyframeRef& /*keyframe*/, CloudSource& /*clouds*/) {}
  virtual bool prepare_ahead(CloudSource& /*clouds*/) { return false; }
  virtual void complete_session(SessionId id) = 0;
  virtual void await_no_more(SessionId /*id*/) {}
  virtual void restore(std::vector<Alignment> alignments, std::uint64_t revision, std::vector<DecisionRecord> decisions,
                       std::vector<SessionId> anchors) = 0;
  virtual void await_attempt(SessionId /*id*/) {}
  virtual void restore_self_likeness(const std::map<SessionId, SelfLikeness>& /*known*/) {}
  virtual void restore_closures(const PairClosures& /*known*/) {}
  virtual Result<AttemptReport> decide(AlignmentId id, Decision decision) = 0;
  virtual Result<AttemptReport> anchor(SessionId id) = 0;
  virtual Result<HandPlacement> place(SessionId /*a*/, SessionId /*b*/, const Pose& /*T_a_b*/, CloudSource& /*clouds*/,
                                      AttemptReport& /*report*/) {
    return HandPlacement();
  }
  virtual SessionCut cut(SessionId /*id*/) const { return {}; }
  virtual AttemptReport set_aside(SessionId /*id*/) { return {}; }
  virtual AttemptReport come_back(SessionId /*id*/) { return {}; }
  virtual AttemptReport move_session(SessionId /*id*/, const std::vector<Keyframe>& /*keyframes*/) { return {}; }
  virtual AttemptReport set_site(SessionId /*id*/, const std::string& /*site*/) { return {}; }
  virtual Result<AttemptReport> freeze(SessionId /*id*/) { return AttemptReport(); }
  virtual Result<AttemptReport> thaw(SessionId /*id*/) { return AttemptReport(); }
  virtual void restore_frozen(const std::vector<FrozenSession>& /*frozen*/) {}
  virtual bool ask_where(SessionId /*id*/, bool /*asks*/) { return false; }
  virtual SessionLocalization localization(SessionId /*id*/) const { return {}; }
  virtual AttemptReport attempt(SessionId id, CloudSource& clouds) = 0;
  virtual const Atlas& atlas() const = 0;
  virtual const std::vector<Alignment>& alignments() const = 0;
  virtual Corrections corrections() const { return {}; }
};

/// helpers: see MergePipeline; must outlive the pipeline.
std::unique_ptr<Pipeline> make_pipeline(const MergeConfig& config, PairHelpers* helpers = nullptr);

}  // namespace headframe
