// Placements by the operator, as the book keeps them.
#include <algorithm>

#include "server/merge/alignment_book.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {

HandPlacement AlignmentBook::place(const OrderedPair& pair, const Judgement& judged,
                                   const std::optional<Pose>& T_a_b_runner_up, bool fits, AttemptReport& report) {
  const auto [a, b] = std::minmax(pair.a, pair.b);
  Judgement best = by_ids(pair, judged);
  best.evidence.probability = calibrated(best.evidence, config_);
  const bool probable = best.evidence.probability >= config_.candidate_probability;
  Alignment now{0, a, b, probable ? AlignmentState::candidate : AlignmentState::rejected, best.T_a_b, best.evidence};
  now.verdict = now.state;
  now.changes = best.changes;
  if (T_a_b_runner_up) now.T_a_b_runner_up = by_ids(pair, *T_a_b_runner_up);
  now.evidence.path_m = sessions_.at(a).path_m() + sessions_.at(b).path_m();
  now.evidence.awaited_m = sessions_.path_awaited_m(pair, judged.T_a_b, judged.evidence);
  Alignment* known = find(a, b);
  if (!fits || !probable) return {now, false};
  if (!known) {
    by_pair_[{a, b}] = alignments_.size();
    now.id = alignments_.empty() ? 1 : alignments_.back().id + 1;
    alignments_.push_back(now);
    known = &alignments_.back();
  }
  now.id = known->id;
  *known = now;
  wait_for_clouds_.erase(now.id);
  report.decided.push_back(decisions_.place(*known));
  known->ruling = decisions_.ruling(*known);
  report.changed.push_back(*known);
  return {*known, true};
}

}  // namespace headframe
