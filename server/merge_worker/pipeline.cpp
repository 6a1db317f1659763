#include "server/merge_worker/pipeline.hpp"

namespace headframe {
namespace {

class RealPipeline : public Pipeline {
 public:
  RealPipeline(const MergeConfig& config, PairHelpers* helpers) : pipeline_(config, helpers) {}
  void add_session(SessionId id, const FamilyId& family, const std::string& site) override {
    pipeline_.add_session(id, family, site);
  }
  void add_keyframe(SessionId id, Keyframe keyframe) override { pipeline_.add_keyframe(id, std::move(keyframe)); }
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds) override {
    pipeline_.prepare_cloud(keyframe, clouds);
  }
  bool prepare_ahead(CloudSource& clouds) override { return pipeline_.prepare_ahead(clouds); }
  void complete_session(SessionId id) override { pipeline_.complete_session(id); }
  void await_no_more(SessionId id) override { pipeline_.await_no_more(id); }
  void restore(std::vector<Alignment> alignments, std::uint64_t revision, std::vector<DecisionRecord> decisions,
               std::vector<SessionId> anchors) override {
    pipeline_.restore(std::move(alignments), revision, std::move(decisions), std::move(anchors));
  }
  void await_attempt(SessionId id) override { pipeline_.await_attempt(id); }
  void restore_self_likeness(const std::map<SessionId, SelfLikeness>& known) override {
    pipeline_.restore_self_likeness(known);
  }
  void restore_closures(const PairClosures& known) override { pipeline_.restore_closures(known); }
  Result<AttemptReport> decide(AlignmentId id, Decision decision) override { return pipeline_.decide(id, decision); }
  Result<AttemptReport> anchor(SessionId id) override { return pipeline_.anchor(id); }
  Result<HandPlacement> place(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds,
                              AttemptReport& report) override {
    return pipeline_.place(a, b, T_a_b, clouds, report);
  }
  SessionCut cut(SessionId id) const override { return pipeline_.cut(id); }
  AttemptReport set_aside(SessionId id) override { return pipeline_.set_aside(id); }
  AttemptReport come_back(SessionId id) override { return pipeline_.come_back(id); }
  AttemptReport move_session(SessionId id, const std::vector<Keyframe>& keyframes) override {
    return pipeline_.move_session(id, keyframes);
  }
  AttemptReport set_site(SessionId id, const std::string& site) override { return pipeline_.set_site(id, site); }
  Result<AttemptReport> freeze(SessionId id) override { return pipeline_.freeze(id); }
  Result<AttemptReport> thaw(SessionId id) override { return pipeline_.thaw(id); }
  void restore_frozen(const std::vector<FrozenSession>& frozen) override { pipeline_.restore_frozen(frozen); }
  bool ask_where(SessionId id, bool asks) override { return pipeline_.ask_where(id, asks); }
  SessionLocalization localization(SessionId id) const override { return pipeline_.localization(id); }
  AttemptReport attempt(SessionId id, CloudSource& clouds) override { return pipeline_.attempt(id, clouds); }
  const Atlas& atlas() const override { return pipeline_.atlas(); }
  const std::vector<Alignment>& alignments() const override { return pipeline_.alignments(); }
  Corrections corrections() const override { return pipeline_.corrections(); }

 private:
  MergePipeline pipeline_;
};

}  // namespace

std::unique_ptr<Pipeline> make_pipeline(const MergeConfig& config, PairHelpers* helpers) {
  return std::make_unique<RealPipeline>(config, helpers);
}

}  // namespace headframe
