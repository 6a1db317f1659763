#pragma once

#include <functional>
#include <map>
#include <set>

#include "server/atlas/hand_placement.hpp"
#include "server/atlas/merge_graph.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// What is known of all pairs of sessions: alignments, the operator's decisions, the anchors, and the atlas that
/// follows from them. It lies in local frames; what is given out lies in those of the robots. Not thread safe.
class AlignmentBook {
 public:
  AlignmentBook(const MergeConfig& config, const SessionMap& sessions) : config_(config), sessions_(sessions) {}

  /// As they were given out once, ordered by id. The atlas is made anew by update_atlas().
  void restore(std::vector<Alignment> alignments, std::vector<DecisionRecord> decisions,
               std::vector<SessionId> anchors);

  /// Of the two, whichever comes first; null: none.
  Alignment* find(SessionId one, SessionId other);
  const Alignment* find(SessionId one, SessionId other) const;
  const Alignment* find(AlignmentId id) const;
  /// Something is known of the pair besides "not there": a candidate or better, or what the operator ruled on.
  bool live(SessionId one, SessionId other) const;
  /// The sessions of which that is so.
  std::set<SessionId> aligned_with(SessionId id) const;
  const DecisionBook& decisions() const { return decisions_; }
  const MergeConfig& config() const { return config_; }
  /// What convinces, or could, waits for clouds that are on their way.
  bool waits_for_clouds(AlignmentId id) const { return wait_for_clouds_.contains(id); }

  /// The verdict on the best placement of a pair becomes its alignment. waits: however probable, a candidate for now.
  void record(const OrderedPair& pair, const Judgement& judged, const std::optional<Pose>& T_a_b_runner_up, bool waits,
              AttemptReport& report);

  /// The verdict on where the operator put it becomes the pair's alignment, a candidate at most, unless it does not
  /// fit, or is improbable and something better is known.
  HandPlacement place(const OrderedPair& pair, const Judgement& judged, const std::optional<Pose>& T_a_b_runner_up,
                      bool fits, AttemptReport& report);

  /// Tells what waited for path of other sessions, where that has come.
  void release_awaited(AttemptReport& report);

  Result<void> decide(AlignmentId id, Decision decision, AttemptReport& report);
  /// False: it was chosen last already. refused: a frozen session of its component keeps the frame.
  Result<bool> anchor(SessionId id);
  /// A session that was set aside is back, or belongs to another site: its alignments stand again as their verdict and
  /// the operator's word say, until the atlas is updated. Gives those that changed.
  std::vector<Alignment> wake(SessionId id);

  /// Keyframes of the session lie elsewhere now: `moved` says where an alignment's placement is to go. What was
  /// verified stays so until it is judged again, which is then done as a whole; but where the other session is not here
  /// nobody knows where they meet, and unless the operator confirmed it, it is a candidate from now on. Gives what is
  /// to be stored, in local frames as they are before the session comes anew: given_out() is for after.
  struct Moved {
    std::vector<Alignment> alignments;
    std::vector<DecisionRecord> decisions;
  };
  using Mover = std::function<Pose(const Alignment& of, const Pose& T_a_b)>;
  Moved moved(SessionId id, const Mover& mover);

  /// Whether anything waits for path or clouds that may be told then.
  bool anything_may_come() const;
  /// Alignments that wait and are merged all the same, to see what would come of it.
  enum class Waiting { none, provisional, all };
  /// What merging would come to, with these answers on where sessions would meet.
  MergeResult merge(const Contacts& contacts, Waiting waiting = Waiting::none) const;
  /// FRAME, step 9: maps merge one after another. `objection`: what the pair that holds an alignment back says.
  void update_atlas(const Contacts& contacts,
                    const std::function<Objection(const std::pair<SessionId, SessionId>&)>& objection,
                    AttemptReport& report);
  /// The atlas is another one, whether transforms changed or not.
  void next_revision(AttemptReport& report);
  void set_revision(std::uint64_t revision) { atlas_.revision = revision; }

  /// The report, the atlas and the alignments in the robots' frames.
  AttemptReport given_out(AttemptReport report);
  const Atlas& atlas_given_out() const { return atlas_given_out_; }
  const Atlas& atlas() const { return atlas_; }  // this and the next: in local frames
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
