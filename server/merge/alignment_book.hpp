#pragma once

#include <functional>
#include <map>
#include <set>

#include "server/atlas/hand_placement.hpp"
#include "server/atlas/merge_graph.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// Everything known about pairs of sessions: alignments, the operator's decisions, the anchors, and the atlas that
/// follows from them. Works in local frames (SessionFrames); functions named given_out use the robots' frames. Not
/// thread safe.
class AlignmentBook {
 public:
  AlignmentBook(const MergeConfig& config, const SessionMap& sessions) : config_(config), sessions_(sessions) {}

  /// Restores what was stored, in the robots' frames, ordered by id. update_atlas() then rebuilds the atlas.
  void restore(std::vector<Alignment> alignments, std::vector<DecisionRecord> decisions,
               std::vector<SessionId> anchors);

  /// The alignment of the two sessions, given in either order; null if there is none.
  Alignment* find(SessionId one, SessionId other);
  const Alignment* find(SessionId one, SessionId other) const;
  const Alignment* find(AlignmentId id) const;
  /// T_a_b of those that are published.
  std::map<AlignmentId, Pose> published() const;
  /// Whether the pair has an alignment that is not rejected, or one on which the operator has decided.
  bool live(SessionId one, SessionId other) const;
  /// The sessions with which this one has such an alignment.
  std::set<SessionId> aligned_with(SessionId id) const;
  const DecisionBook& decisions() const { return decisions_; }
  const MergeConfig& config() const { return config_; }
  /// Whether the alignment waits for requested clouds.
  bool waits_for_clouds(AlignmentId id) const { return wait_for_clouds_.contains(id); }

  /// Makes the verdict on the best placement of a pair its alignment, whose probability is calibrated(). waits: clouds
  /// are still expected, so a new placement becomes a candidate at most, however probable it is.
  void record(const OrderedPair& pair, const Judgement& judged, const std::optional<Pose>& T_a_b_runner_up, bool waits,
              AttemptReport& report);

  /// Makes the verdict on a placement by the operator the pair's alignment, at most a candidate. Does not, if the
  /// placement does not fit, or if it is improbable and something better is known.
  HandPlacement place(const OrderedPair& pair, const Judgement& judged, const std::optional<Pose>& T_a_b_runner_up,
                      bool fits, AttemptReport& report);

  /// Publishes alignments that waited only for path, their own or that of other sessions, if it has been driven.
  void release_awaited(AttemptReport& report);

  Result<void> decide(AlignmentId id, Decision decision, AttemptReport& report);
  /// Returns false if it was chosen last already. refused: a frozen session of its component keeps the frame.
  Result<bool> anchor(SessionId id);
  /// For a session that was set aside and is back, or that belongs to another site now: resets the states of its
  /// alignments to what their verdicts and the operator's decisions say, until the atlas is updated. Returns those that
  /// changed.
  std::vector<Alignment> wake(SessionId id);

  /// For a session whose keyframes were moved: moves the placements of its alignments, and those in the decisions on
  /// them, as `mover` says. Verified alignments stay verified until they are judged again as a whole. If the other
  /// session is absent, however, nobody knows where the two meet, and a verified alignment becomes a candidate unless
  /// the operator confirmed it. Returns what has to be stored, in local frames as they are before the session is added
  /// again; call given_out() on it afterwards.
  struct Moved {
    std::vector<Alignment> alignments;
    std::vector<DecisionRecord> decisions;
  };
  using Mover = std::function<Pose(const Alignment& of, const Pose& T_a_b)>;
  Moved moved(SessionId id, const Mover& mover);

  /// Whether any alignment waits for path or clouds and may be merged later.
  bool anything_may_come() const;
  /// Which waiting alignments are merged as well, to see what would follow.
  enum class Waiting { none, provisional, all };
  /// What merging would result in. `contacts` says whether sessions contradict each other where they would meet.
  MergeResult merge(const Contacts& contacts, Waiting waiting = Waiting::none) const;
  /// FRAME, step 9: merges maps one after another. `objection` describes the pair of sessions that contradicts an
  /// alignment.
  void update_atlas(const Contacts& contacts,
                    const std::function<Objection(const std::pair<SessionId, SessionId>&)>& objection,
                    AttemptReport& report);
  /// Increments the atlas revision even if no transform changed.
  void next_revision(AttemptReport& report);
  void set_revision(std::uint64_t revision) { atlas_.revision = revision; }

  /// Translates the report, the atlas and the alignments into the robots' frames.
  AttemptReport given_out(AttemptReport report);
  const Atlas& atlas_given_out() const { return atlas_given_out_; }
  const Atlas& atlas() const { return atlas_; }  // this and alignments(): in local frames
  const std::vector<Alignment>& alignments() const { return alignments_; }
  const std::vector<Alignment>& alignments_given_out() const { return alignments_given_out_; }

 private:
  AlignmentState awaiting_state(const Evidence& evidence) const;
  AlignmentState state_of(const OrderedPair& pair, const Judgement& best, const Alignment* known, bool waits) const;
  bool waits(const Alignment& alignment) const;
  bool may_come(const Alignment& alignment) const;
  MergeResult merge_spoken(std::vector<Alignment> spoken, const Contacts& contacts) const;
  std::set<SessionId> unsettled_sessions(const MergeResult& then) const;
  MergeResult merge_undisputed(const Contacts& contacts) const;
  void add_provisional(std::vector<Component>& components, const Contacts& contacts) const;
  void note_moved_sessions(const std::vector<Component>& now, AttemptReport& report) const;

  const MergeConfig config_;
  const SessionMap& sessions_;
  std::vector<Alignment> alignments_;  // by id
  std::map<std::pair<SessionId, SessionId>, std::size_t> by_pair_;
  std::set<AlignmentId> wait_for_clouds_;
  DecisionBook decisions_;
  std::vector<SessionId> anchors_;  // in the order they were chosen
  Atlas atlas_, atlas_given_out_;
  std::vector<Alignment> alignments_given_out_;
};

}  // namespace headframe
