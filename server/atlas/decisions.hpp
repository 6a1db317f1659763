#pragma once
// What the operator decided about alignments, and what follows from it. Pure: no store, no clock.

#include <functional>
#include <vector>

#include "common/result.hpp"
#include "server/atlas/alignment.hpp"
#include "server/session/same_placement.hpp"

namespace headframe {

/// place: the operator laid the two sessions on each other; decided by AlignmentBook::place() alone.
enum class Decision { confirm, refuse, retract, undo, place };

std::string_view to_string(Decision decision);
std::optional<Decision> decision_from(std::string_view name);

/// One decision, as it is kept for good. An undo is no record of its own: it marks the one it takes back.
struct DecisionRecord {
  std::int64_t id = 0;  // 1, 2, ... in the order of the decisions
  AlignmentId alignment = 0;
  Decision decision = Decision::confirm;
  Pose T_a_b = Pose::Identity();  // the placement that was decided on
  double seen_points = 0;         // Evidence::seen_points at that time
  bool undone = false;
};

/// What may become of a placement that the evidence proposes.
enum class Proposal {
  open,          // the operator has said nothing of it
  as_candidate,  // refused once, on much less evidence: shown again, and published only when the operator confirms it
  suppressed,    // refused, on much the same evidence
};

/// When two placements of a pair count as the same one, and how much more evidence reopens a refused one.
struct DecisionRules {
  PlacementTolerance same = same_as_ruled;
  double reopen_ratio = 2;     // of seen_points now to those at the refusal ...
  double reopen_least = 2000;  // ... and at least so many more: twice of nothing is nothing
};

/// All decisions. A confirmation stands until something newer is decided on its alignment or it is undone; a refusal
/// or retraction suppresses its placement until it is undone, or while the alignment is confirmed. Not thread safe.
class DecisionBook {
 public:
  explicit DecisionBook(const DecisionRules& rules = {}) : rules_(rules) {}

  /// As they were stored, ordered by id.
  void restore(std::vector<DecisionRecord> records) { records_ = std::move(records); }

  /// The record to be stored, new or changed (undo); none when the decision stands already. refused: it does not fit
  /// the alignment, with the reason and what to do instead.
  Result<std::optional<DecisionRecord>> decide(const Alignment& alignment, Decision decision);

  /// The operator laid it where it is now; whatever was said of this placement before. To be stored.
  DecisionRecord place(const Alignment& alignment);

  /// The standing word on the alignment as it is now placed.
  Ruling ruling(const Alignment& alignment) const;
  /// Each alignment's ruling; records and placements in the same frames.
  void rule(std::vector<Alignment>& alignments) const;
  Proposal proposal(AlignmentId alignment, const Pose& T_a_b, double seen_points) const;
  /// The placement that the standing word confirms; none when it is another word.
  std::optional<Pose> confirmed_at(AlignmentId alignment) const;
  const std::vector<DecisionRecord>& records() const { return records_; }

  /// The sessions of these alignments lie elsewhere: what was decided on goes along. Gives the records of them.
  std::vector<DecisionRecord> move(AlignmentId alignment, const std::function<Pose(const Pose& T_a_b)>& mover);

 private:
  bool same(const Pose& T, const Pose& U) const;
  const DecisionRecord* standing(AlignmentId alignment, const Pose& T_a_b) const;
  const DecisionRecord* newest_of(AlignmentId alignment) const;
  Result<std::optional<DecisionRecord>> undo(const Alignment& alignment);

  DecisionRules rules_;
  std::vector<DecisionRecord> records_;
};

/// The state that follows from ruling and verdict, before the merge graph has looked at it: confirmed ones are
/// verified, whatever the evidence says.
AlignmentState decided_state(const Alignment& alignment);

}  // namespace headframe
