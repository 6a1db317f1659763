#pragma once
// The operator's decisions about alignments, and what follows from them. Pure: no store, no clock.

#include <functional>
#include <vector>

#include "common/result.hpp"
#include "server/atlas/alignment.hpp"
#include "server/session/same_placement.hpp"

namespace headframe {

/// place: the operator placed the two sessions on each other; made only by AlignmentBook::place().
enum class Decision { confirm, refuse, retract, undo, place };

std::string_view to_string(Decision decision);
std::optional<Decision> decision_from(std::string_view name);

/// One decision, kept for good. An undo has no record of its own; it marks the record that it takes back.
struct DecisionRecord {
  std::int64_t id = 0;  // 1, 2, ... in the order of the decisions
  AlignmentId alignment = 0;
  Decision decision = Decision::confirm;
  Pose T_a_b = Pose::Identity();  // the placement that was decided on
  double seen_points = 0;         // Evidence::seen_points at that time
  bool undone = false;
};

/// What may happen to a placement that the evidence proposes.
enum class Proposal {
  open,          // the operator has decided nothing about it
  as_candidate,  // refused once on much less evidence: shown again, but published only when confirmed
  suppressed,    // refused on much the same evidence
};

/// When two placements of a pair count as the same one, and how much more evidence reopens a refused one.
struct DecisionRules {
  PlacementTolerance same = same_as_ruled;
  double reopen_ratio = 2;     // of seen_points now to those at the refusal ...
  double reopen_least = 2000;  // ... and at least this many more, for refusals on little evidence
};

/// All decisions. A confirmation stands until something newer is decided on its alignment or it is undone; a refusal
/// or retraction suppresses its placement until it is undone, or while the alignment is confirmed. Not thread safe.
class DecisionBook {
 public:
  explicit DecisionBook(const DecisionRules& rules = {}) : rules_(rules) {}

  /// Restores stored records, ordered by id.
  void restore(std::vector<DecisionRecord> records) { records_ = std::move(records); }

  /// Returns the record to store, new or changed (undo); nullopt if the decision stands already. refused: it does not
  /// apply to the alignment; the message says why and what to do instead.
  Result<std::optional<DecisionRecord>> decide(const Alignment& alignment, Decision decision);

  /// Records that the operator placed the alignment where it is now, whatever was decided about this placement before.
  /// Returns the record to store.
  DecisionRecord place(const Alignment& alignment);

  /// The standing decision about the alignment at its present placement.
  Ruling ruling(const Alignment& alignment) const;
  /// Sets the ruling of each alignment; records and placements have to be in the same frames.
  void rule(std::vector<Alignment>& alignments) const;
  Proposal proposal(AlignmentId alignment, const Pose& T_a_b, double seen_points) const;
  /// The placement confirmed by the standing decision; nullopt if that is not a confirmation.
  std::optional<Pose> confirmed_at(AlignmentId alignment) const;
  const std::vector<DecisionRecord>& records() const { return records_; }

  /// For moved sessions: moves the placements of the alignment's records by `mover`. Returns these records.
  std::vector<DecisionRecord> move(AlignmentId alignment, const std::function<Pose(const Pose& T_a_b)>& mover);

 private:
  bool same(const Pose& T, const Pose& U) const;
  const DecisionRecord* standing(AlignmentId alignment, const Pose& T_a_b) const;
  const DecisionRecord* newest_of(AlignmentId alignment) const;
  Result<std::optional<DecisionRecord>> undo(const Alignment& alignment);

  DecisionRules rules_;
  std::vector<DecisionRecord> records_;
};

/// The state that follows from ruling and verdict, before the merge graph is applied: a confirmed alignment is
/// verified, whatever the evidence says.
AlignmentState decided_state(const Alignment& alignment);

}  // namespace headframe
