#include "server/atlas/decisions.hpp"

#include <algorithm>
#include <array>

namespace headframe {
namespace {

constexpr std::array<std::string_view, 5> names{"confirm", "refuse", "retract", "undo", "place"};

tl::unexpected<Error> does_not_fit(const Alignment& alignment, const std::string& why) {
  return failure(ErrorCode::refused, "alignment " + std::to_string(alignment.id) + " " + why);
}

}  // namespace

std::string_view to_string(Decision decision) { return names.at(static_cast<std::size_t>(decision)); }

std::optional<Decision> decision_from(std::string_view name) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<Decision>(i);
  return std::nullopt;
}

bool DecisionBook::same(const Pose& T, const Pose& U) const {
  const Pose error = T.inverse() * U;
  return error.translation().norm() <= rules_.same.metres && rotation_angle_rad(error) <= rules_.same.radians;
}

/// A confirmation applies to the alignment, wherever later evidence moves it, until a newer decision; refusals and
/// retractions apply only to their placement.
const DecisionRecord* DecisionBook::standing(AlignmentId alignment, const Pose& T_a_b) const {
  const DecisionRecord* newest = newest_of(alignment);
  if (!newest || newest->decision == Decision::confirm) return newest;
  const auto found = std::find_if(records_.rbegin(), records_.rend(), [&](const DecisionRecord& r) {
    return r.alignment == alignment && !r.undone && r.decision != Decision::confirm && same(r.T_a_b, T_a_b);
  });
  return found == records_.rend() ? nullptr : &*found;
}

const DecisionRecord* DecisionBook::newest_of(AlignmentId alignment) const {
  const auto found = std::find_if(records_.rbegin(), records_.rend(),
                                  [&](const DecisionRecord& r) { return r.alignment == alignment && !r.undone; });
  return found == records_.rend() ? nullptr : &*found;
}

std::optional<Pose> DecisionBook::confirmed_at(AlignmentId alignment) const {
  const DecisionRecord* newest = newest_of(alignment);
  if (!newest || newest->decision != Decision::confirm) return std::nullopt;
  return newest->T_a_b;
}

void DecisionBook::rule(std::vector<Alignment>& alignments) const {
  for (Alignment& alignment : alignments) alignment.ruling = ruling(alignment);
}

Ruling DecisionBook::ruling(const Alignment& alignment) const {
  const DecisionRecord* word = standing(alignment.id, alignment.T_a_b);
  if (!word) return Ruling::none;
  if (word->decision == Decision::confirm) return Ruling::confirmed;
  if (word->decision == Decision::place) return Ruling::placed;
  // A placement that is proposed again on much more evidence is open: the refusal was based on less.
  if (proposal(alignment.id, alignment.T_a_b, alignment.evidence.seen_points) != Proposal::suppressed)
    return Ruling::none;
  return word->decision == Decision::refuse ? Ruling::refused : Ruling::retracted;
}

Proposal DecisionBook::proposal(AlignmentId alignment, const Pose& T_a_b, double seen_points) const {
  const DecisionRecord* word = standing(alignment, T_a_b);
  if (!word || word->decision == Decision::confirm || word->decision == Decision::place) return Proposal::open;
  const double then = word->seen_points;
  const bool grown = seen_points >= rules_.reopen_ratio * then && seen_points >= then + rules_.reopen_least;
  return grown ? Proposal::as_candidate : Proposal::suppressed;
}

Result<std::optional<DecisionRecord>> DecisionBook::decide(const Alignment& alignment, Decision decision) {
  if (decision == Decision::undo) return undo(alignment);
  if (decision == Decision::place) return does_not_fit(alignment, "is placed by the transform, not by its number");
  const Ruling now = ruling(alignment);
  const bool stands = (decision == Decision::confirm && now == Ruling::confirmed) ||
                      (decision == Decision::refuse && now == Ruling::refused) ||
                      (decision == Decision::retract && now == Ruling::retracted);
  if (stands) return std::nullopt;
  if (!has_placement(alignment)) return does_not_fit(alignment, "has no placement to decide on: nothing fitted");
  const bool in_force = alignment.state == AlignmentState::published || now == Ruling::confirmed;
  if (decision == Decision::refuse && in_force) return does_not_fit(alignment, "is published; retract it instead");
  if (decision == Decision::retract && !in_force)
    return does_not_fit(alignment,
                        "is not published but " + std::string(to_string(alignment.state)) + "; refuse it instead");
  records_.push_back({static_cast<std::int64_t>(records_.size()) + 1, alignment.id, decision, alignment.T_a_b,
                      alignment.evidence.seen_points, false});
  return records_.back();
}

std::vector<DecisionRecord> DecisionBook::move(AlignmentId alignment,
                                               const std::function<Pose(const Pose& T_a_b)>& mover) {
  std::vector<DecisionRecord> moved;
  for (DecisionRecord& record : records_) {
    if (record.alignment != alignment) continue;
    record.T_a_b = mover(record.T_a_b);
    moved.push_back(record);
  }
  return moved;
}

DecisionRecord DecisionBook::place(const Alignment& alignment) {
  records_.push_back({static_cast<std::int64_t>(records_.size()) + 1, alignment.id, Decision::place, alignment.T_a_b,
                      alignment.evidence.seen_points, false});
  return records_.back();
}

Result<std::optional<DecisionRecord>> DecisionBook::undo(const Alignment& alignment) {
  const DecisionRecord* newest = newest_of(alignment.id);
  if (!newest) return does_not_fit(alignment, "has no decision to undo");
  DecisionRecord& record = records_[static_cast<std::size_t>(newest - records_.data())];
  record.undone = true;
  return record;
}

AlignmentState decided_state(const Alignment& alignment) {
  switch (alignment.ruling) {
    case Ruling::confirmed: return AlignmentState::verified;
    case Ruling::refused: return AlignmentState::rejected;
    case Ruling::retracted: return AlignmentState::retracted;
    case Ruling::placed:
    case Ruling::none: break;
  }
  return alignment.verdict;
}

}  // namespace headframe
