#pragma once
// The server's data flow on one page: keyframes in, alignments and atlas revisions out. It follows Algorithm 1 of the
// FRAME paper and adds a verdict.

#include <memory>
#include <vector>

#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/atlas/hand_placement.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/localization.hpp"
#include "server/merge/merge_config.hpp"
#include "server/session/pair_task.hpp"
#include "server/session/session_cut.hpp"

namespace headframe {

/// Owns descriptors, alignments and the atlas in memory. Not thread safe: one thread calls it (server/merge_worker).
/// Deterministic: the same calls give the same results, whatever the thread count of the registration.
class MergePipeline {
 public:
  /// helpers: who may search pairs ahead of attempts; without any, and with any, the results are the same. Must outlive
  /// this.
  explicit MergePipeline(const MergeConfig& config, PairHelpers* helpers = nullptr);
  ~MergePipeline();

  /// Sessions may be added in any order and their keyframes interleaved; the keyframes of one session come in the order
  /// of their sequence. Sessions of two sites are never tried with each other; only the operator can place one on the
  /// other. Adding a session that exists changes nothing.
  void add_session(SessionId id, const FamilyId& family, const std::string& site = {});
  void add_keyframe(SessionId id, Keyframe keyframe);

  /// Prepares a cloud that has arrived for registration, ahead of the attempt that needs it. Optional.
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds);

  /// Computes one piece of what attempts will need: whether a session repeats itself, or the submap of a keyframe.
  /// Takes some tens of milliseconds; returns false when nothing is left. Optional: attempts compute what is missing.
  bool prepare_ahead(CloudSource& clouds);

  /// The session has ended, or no keyframe has come for a while: however short it is, it may merge now. May be
  /// repeated; a further keyframe makes the session grow again.
  void complete_session(SessionId id);

  /// Merges of other sessions no longer wait for this session, which still grows.
  void await_no_more(SessionId id);

  /// Forgets the session. Its alignments have no effect until it is added again with all its keyframes and come_back()
  /// is called.
  AttemptReport set_aside(SessionId id);
  AttemptReport come_back(SessionId id);

  /// The robot's SLAM moved keyframes of the session. `keyframes`: all of the session's keyframes, unchanged except for
  /// their poses in its local frame. Everything derived from the old poses is rebuilt. Alignments move along, so that
  /// where the two sessions meet the keyframes keep their place on the other. Merged sessions stay merged for now;
  /// nothing new is merged until the next attempt, which judges everything anew. Loop closures stay valid, since they
  /// connect keyframes. If no keyframe moved, or the session is frozen or absent, nothing changes.
  AttemptReport move_session(SessionId id, const std::vector<Keyframe>& keyframes);

  /// Assigns the session to another site. Alignments with sessions of other sites no longer count, unless the operator
  /// confirmed them, and earlier alignments with sessions at `site` count again. This does not search.
  AttemptReport set_site(SessionId id, const std::string& site);

  /// freeze: from now on nothing moves the session; others are aligned to it, and its component is anchored to it, or
  /// to one that was frozen before. This lasts until thaw(), even if the session is set aside meanwhile. not_found: no
  /// such session; refused: it is frozen already (freeze) or not frozen (thaw), or there is no keyframe to freeze.
  Result<AttemptReport> freeze(SessionId id);
  Result<AttemptReport> thaw(SessionId id);
  /// As they were stored; before restore().
  void restore_frozen(std::vector<FrozenSession> frozen);

  /// After a restart, once all sessions and keyframes were added: stored alignments and decisions, ordered by id; the
  /// last revision; and the anchors in the order they were chosen.
  void restore(std::vector<Alignment> alignments, std::uint64_t revision, std::vector<DecisionRecord> decisions = {},
               std::vector<SessionId> anchors = {});
  /// After restore(): no attempt has used all keyframes of the session, or none since it ended. Merges that it might
  /// contradict wait for it.
  void await_attempt(SessionId id);

  /// Call before restore(): how often sessions look like themselves, as attempts reported it. What is missing is
  /// computed by prepare_ahead(), or when an attempt needs it.
  void restore_self_likeness(std::map<SessionId, SelfLikeness> known);
  /// As they were stored; before restore().
  void restore_closures(const PairClosures& known);

  /// Applies an operator's decision to an alignment, and updates the atlas at once. not_found: no such alignment;
  /// refused: the decision does not apply to it. Nothing changes if the decision stands already. After an undo, new
  /// attempts for both sessions find what had been suppressed.
  Result<AttemptReport> decide(AlignmentId id, Decision decision);

  /// The operator placed b on a roughly: registers the placement and compares it with those that the search proposes.
  /// It becomes the pair's alignment, at most a candidate until it is confirmed, unless it is improbable or
  /// registration moves it too far. Fills the report, which the caller stores; the report may request clouds even if
  /// this fails. not_found: no such session; refused: the two are merged, or there are no clouds where they would meet;
  /// unavailable: the clouds there are still to come.
  Result<HandPlacement> place(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds, AttemptReport& report);

  /// The session's frame becomes the frame of its component, now and after later merges, until another session of the
  /// component is chosen. not_found: no such session; refused: a frozen session keeps the frame. Returns an unchanged
  /// atlas if it was chosen last already.
  Result<AttemptReport> anchor(SessionId id);

  /// Sets whether the session's robot asks where it is. While it does, its pairs are considered however short it is,
  /// and again every two metres. What is found is merged by the usual rules. Returns false for a session that was not
  /// added.
  bool ask_where(SessionId id, bool asks);

  /// What the robot can be told about its place as of the last attempt. Pure.
  SessionLocalization localization(SessionId id) const;

  /// Tries to merge this session with those that look most like it, and with those for which an alignment is known.
  /// Sessions of other descriptor families count too; they are ranked by their wall profiles.
  AttemptReport attempt(SessionId id, CloudSource& clouds);

  /// Judges a given placement, wherever it comes from; nothing is recorded. a < b.
  Judgement judge_placement(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds);

  /// The keyframes of the session that are left out of merging because its odometry jumped.
  SessionCut cut(SessionId id) const;

  const Atlas& atlas() const;
  /// The sessions that the pose graph corrects, in the robots' frames.
  const Corrections& corrections() const;
  const std::vector<Alignment>& alignments() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace headframe
