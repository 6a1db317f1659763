#pragma once
// The server's data flow on one page: keyframes in, alignments and atlas revisions out. It reads as the paper does
// (FRAME, Algorithm 1), with the verdict that the paper lacks.

#include <memory>
#include <vector>

#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/atlas/hand_placement.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/localization.hpp"
#include "server/merge/merge_config.hpp"
#include "server/session/session_cut.hpp"

namespace headframe {

/// Owns descriptors, alignments and the atlas in memory. Not thread safe: one thread calls it (server/merge_worker).
/// Deterministic: the same calls give the same results, whatever the thread count of the registration.
class MergePipeline {
 public:
  explicit MergePipeline(const MergeConfig& config);
  ~MergePipeline();

  /// Sessions and keyframes come in any order of sessions; keyframes of one session in the order of their sequence.
  /// Sessions of two sites never meet, but where the operator lays one on the other. A session that is there already
  /// stays as it is.
  void add_session(SessionId id, const FamilyId& family, const std::string& site = {});
  void add_keyframe(SessionId id, Keyframe keyframe);

  /// Its cloud came: makes it ready for registration ahead of the attempt that needs it. Optional.
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds);

  /// Makes one part of what attempts will need: whether a session's mine repeats itself, or the surroundings of a
  /// keyframe. Some tens of milliseconds; false when nothing is left. Optional: attempts make what they miss.
  bool prepare_ahead(CloudSource& clouds);

  /// No keyframe follows, or none has for a while: however short it is, it may merge now. Harmless when repeated; a
  /// keyframe that comes after all ends it.
  void complete_session(SessionId id);

  /// Merges of others wait no more for what the session, which still grows, comes to say.
  void await_no_more(SessionId id);

  /// Forgets the session; what is known of its alignments rests until it is added again, with all its keyframes, and
  /// come_back() says so.
  AttemptReport set_aside(SessionId id);
  AttemptReport come_back(SessionId id);

  /// The robot's SLAM has moved keyframes of the session: these are all of it, as they came but for where they lie in
  /// the session's local frame now. What was made of them is made anew. Alignments are moved along, so that where the
  /// two sessions meet the keyframes stay where they lay on the other; what is merged stays so for now, nothing else is
  /// merged until the next attempt, and that judges all of it anew. Loop closures stay, for they are between keyframes.
  /// Nothing changes where no keyframe moved; a frozen session and one that is not here stay as they are.
  AttemptReport move_session(SessionId id, const std::vector<Keyframe>& keyframes);

  /// It was driven in another mine than was thought: what merged it with sessions there counts no more, unless the
  /// operator confirmed it, and what is known of those at `site` counts again. Nothing is looked for yet.
  AttemptReport set_site(SessionId id, const std::string& site);

  /// Nothing moves the session any more, from where it lies now: others align to it, and its component is anchored to
  /// it, or to one that was frozen before. Until it is thawed, also when it was set aside meanwhile. not_found: no such
  /// session; refused: it is frozen already, or it is not, or there is no keyframe to freeze.
  Result<AttemptReport> freeze(SessionId id);
  Result<AttemptReport> thaw(SessionId id);
  /// As they were stored; before restore().
  void restore_frozen(std::vector<FrozenSession> frozen);

  /// After a restart, once all sessions and keyframes were added: alignments and decisions as they were stored, ordered
  /// by id, the last revision, and the anchors in the order they were chosen.
  void restore(std::vector<Alignment> alignments, std::uint64_t revision, std::vector<DecisionRecord> decisions = {},
               std::vector<SessionId> anchors = {});

  /// Before restore(): how often sessions look like themselves, as attempts reported it. What is not known is looked at
  /// by prepare_ahead(), or when an attempt asks for it.
  void restore_self_likeness(std::map<SessionId, SelfLikeness> known);
  /// As they were stored; before restore().
  void restore_closures(const PairClosures& known);

  /// The operator's word on an alignment, put into the atlas at once. not_found: no such alignment; refused: the
  /// decision does not fit it. Nothing changes when it stands already. After an undo, attempts for both sessions find
  /// what had been suppressed.
  Result<AttemptReport> decide(AlignmentId id, Decision decision);

  /// The operator laid b on a roughly: registered, and judged beside what is proposed without him. Recorded as the
  /// pair's alignment, a candidate at most until it is confirmed, unless it is improbable, or registration takes it
  /// elsewhere. Fills the report, which is to be stored; on a failure too it may ask for clouds. not_found: no such
  /// session; refused: the two are merged, or nobody has clouds where they would meet; unavailable: the clouds there
  /// are still to come.
  Result<HandPlacement> place(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds, AttemptReport& report);

  /// The session's frame becomes its component's, now and after later merges, until another of the component is chosen.
  /// not_found: no such session; refused: a frozen one keeps the frame. Nothing changes when it was chosen last
  /// already.
  Result<AttemptReport> anchor(SessionId id);

  /// Whether the session's robot asks where it is: then its pairs are looked at however short it is, and again after
  /// each two metres. What is found is merged by the same rules as ever. False for a session that was not added.
  bool ask_where(SessionId id, bool asks);

  /// What can be told its robot as of the last attempt. Pure.
  SessionLocalization localization(SessionId id) const;

  /// Tries to merge this session with every other session of its family.
  AttemptReport attempt(SessionId id, CloudSource& clouds);

  /// The verdict on a placement that is handed in, wherever it comes from; nothing is recorded. a < b.
  Judgement judge_placement(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds);

  /// Keyframes of the session that are left out of merging, from a jump of its odometry on.
  SessionCut cut(SessionId id) const;

  const Atlas& atlas() const;
  /// Of the sessions that the pose graph bends, between the frames of the robots.
  const Corrections& corrections() const;
  const std::vector<Alignment>& alignments() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace headframe
