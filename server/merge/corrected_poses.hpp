#pragma once
// The pose graph of every component: a corrected pose for each keyframe, updated only where something changed.

#include <set>
#include <span>

#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/atlas/pose_constraint.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// Owns the corrections. They are derived data: nothing is merged or withdrawn because of them, and the same sessions,
/// alignments and loop closures give the same corrections after a restart, up to moved_m. Not thread safe.
class CorrectedPoses {
 public:
  static constexpr double moved_m = 0.005;  // smaller movements are not propagated

  explicit CorrectedPoses(const SessionMap& sessions) : sessions_(sessions) {}

  /// Replaces the loop closures of the pair.
  void set(PairClosures closures) { closures_[{closures.a, closures.b}] = std::move(closures.places); }
  /// Marks the session as changed: the next update optimises it again.
  void touch(SessionId session) { changed_.insert(session); }
  void forget(SessionId session) {
    std::erase_if(closures_, [&](const auto& k) { return k.first.first == session || k.first.second == session; });
  }

  /// The session's keyframes were moved: it is optimised again from scratch, with the same loop closures, which are
  /// returned.
  std::vector<PairClosures> note_moved(SessionId session);

  /// Optimises the sessions whose published alignments or loop closures changed, their neighbours, and further sessions
  /// as far as something moves. The first keyframe of a component's anchor stays fixed, and so do all keyframes of a
  /// frozen session. A session that is alone is corrected where it closed a loop. In local frames. Throws Cancelled.
  void update(std::span<const Component> components, std::span<const Alignment> alignments);

  /// T_component_session between the frames of the robots.
  const Corrections& given_out() const { return given_out_; }

 private:
  using Pair = std::pair<SessionId, SessionId>;  // first < second; equal for closures within one session
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
  std::set<SessionId> changed_;  // sessions that changed, came or went since the last update
  Corrections corrections_, given_out_;
};

}  // namespace headframe
