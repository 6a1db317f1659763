#pragma once
// The pose graph of every component: a corrected pose of each keyframe, and no more work than what changed asks for.

#include <set>
#include <span>

#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/atlas/pose_constraint.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// Owns the corrections. They are derived: nothing is merged or withdrawn because of them, and the same sessions,
/// alignments and loop closures give the same after a restart, but for what lies below moved_m. Not thread safe.
class CorrectedPoses {
 public:
  static constexpr double moved_m = 0.005;  // what moves less takes nothing else along

  explicit CorrectedPoses(const SessionMap& sessions) : sessions_(sessions) {}

  /// They replace those of the pair before.
  void set(PairClosures closures) { closures_[{closures.a, closures.b}] = std::move(closures.places); }
  /// It may move again: the next update looks at it.
  void touch(SessionId session) { changed_.insert(session); }
  void forget(SessionId session) {
    std::erase_if(closures_, [&](const auto& k) { return k.first.first == session || k.first.second == session; });
  }

  /// Its keyframes lie elsewhere now: it counts as new, and its loop closures stay. Gives them.
  std::vector<PairClosures> note_moved(SessionId session);

  /// Optimises what the published alignments of `alignments` and the loop closures changed: the sessions that they are
  /// of, those beside them, and on from there as far as something moves. The first keyframe of a component's anchor
  /// stays where it is, and so do all of a frozen session. A session that stands alone is corrected where it closed a
  /// loop. Local frames. Throws Cancelled.
  void update(std::span<const Component> components, std::span<const Alignment> alignments);

  /// T_component_session between the frames of the robots.
  const Corrections& given_out() const { return given_out_; }

 private:
  using Pair = std::pair<SessionId, SessionId>;  // first < second, or both the same: within a session
  struct PairEdges {
    Pose T_a_b = Pose::Identity();
    PoseConstraints measured;
    std::vector<PoseConstraint> edges;
  };
  struct Work;  // on one component

  void refresh(std::span<const Alignment> alignments);
  void keep(const Pair& pair, PairEdges edges);
  void place_groups(const Work& work);
  void hold_frozen(const Work& work);
  bool is_frozen(SessionId session) const { return sessions_.frozen().contains(session); }
  void optimise_component(Work& work);
  std::set<SessionId> solve(const Work& work, const std::set<SessionId>& active, const Corrections& before);
  Pose corrected(const KeyframeRef& keyframe) const;
  Pose raw(const KeyframeRef& keyframe) const;
  void give_out();

  const SessionMap& sessions_;
  std::map<Pair, PoseConstraints> closures_;
  std::map<Pair, PairEdges> pairs_;
  std::set<SessionId> changed_;  // of what came or went since the last update
  Corrections corrections_, given_out_;
};

}  // namespace headframe
