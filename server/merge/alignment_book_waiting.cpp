// Convincing alignments that wait for path: when they are published, what they hold back meanwhile, and where they
// would put sessions.
#include <algorithm>

#include "server/merge/alignment_book.hpp"

namespace headframe {

/// The state of a convincing alignment. Where places look alike, it is not even provisional, since nearly as often it
/// is a copy.
AlignmentState AlignmentBook::awaiting_state(const Evidence& e) const {
  if (e.awaited_m <= 0) return AlignmentState::verified;
  const bool worth_telling = e.awaited_m <= config_.provisional_m && e.similar_places < config_.look_alikes &&
                             e.probability >= config_.provisional_probability;
  return worth_telling ? AlignmentState::provisional : AlignmentState::candidate;
}

/// Handles pairs that are no longer judged, because both sessions have ended and were tried: they wait only for others.
void AlignmentBook::release_awaited(AttemptReport& report) {
  for (Alignment& k : alignments_) {
    if (!waits(k) || !sessions_.contains(k.a) || !sessions_.contains(k.b)) continue;
    if (!sessions_.at(k.a).looked_at || !sessions_.at(k.b).looked_at) continue;
    k.evidence.awaited_m = sessions_.path_awaited_m({k.a, k.b}, k.T_a_b, k.evidence);
    const AlignmentState now = awaiting_state(k.evidence);
    if (now == k.state) continue;
    k.state = k.verdict = now;
    report.changed.push_back(k);
  }
}

/// Waits only for path: not for clouds, nor for the operator after a refusal.
bool AlignmentBook::waits(const Alignment& k) const {
  if (k.state == AlignmentState::provisional) return true;
  return k.state == AlignmentState::candidate && k.evidence.awaited_m > 0 && convinces(k.evidence, config_) &&
         !wait_for_clouds_.contains(k.id) && k.ruling == Ruling::none &&
         decisions_.proposal(k.id, k.T_a_b, k.evidence.seen_points) == Proposal::open;
}

/// Whether it may be published soon: it waits for path, or it is a candidate for which clouds were requested that could
/// make it acceptable.
bool AlignmentBook::may_come(const Alignment& k) const {
  return waits(k) || (k.state == AlignmentState::candidate && k.ruling == Ruling::none && waits_for_clouds(k.id));
}

bool AlignmentBook::anything_may_come() const {
  return std::any_of(alignments_.begin(), alignments_.end(), [&](const Alignment& k) { return may_come(k); });
}

/// The sessions of components that a waiting alignment might still join to others, because not all contacts are
/// checked.
std::set<SessionId> AlignmentBook::unsettled_sessions(const MergeResult& then) const {
  std::set<SessionId> ends, out;
  for (std::size_t i = 0; i < alignments_.size(); ++i) {
    const Alignment& k = alignments_[i];
    if (may_come(k) && then.states[i] != AlignmentState::published && !then.contradicted_by[i]) ends.insert({k.a, k.b});
  }
  for (const Component& component : then.components)
    if (std::any_of(component.placements.begin(), component.placements.end(),
                    [&](const Placement& p) { return ends.contains(p.session); }))
      for (const Placement& p : component.placements) out.insert(p.session);
  return out;
}

/// Waiting alignments may turn out to be right. So where places look alike, nothing new is published that would be
/// contradicted if they did: it is held back, like an alignment that other sessions contradict.
MergeResult AlignmentBook::merge_undisputed(const Contacts& contacts) const {
  if (!anything_may_come()) return merge(contacts);
  const MergeResult then = merge(contacts, Waiting::all);
  const std::set<SessionId> unsettled = unsettled_sessions(then);
  std::vector<Alignment> spoken = alignments_;
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < spoken.size(); ++i) {
    Alignment& k = spoken[i];
    const bool open = k.state == AlignmentState::verified && k.ruling == Ruling::none &&
                      k.evidence.similar_places >= config_.look_alikes;
    const bool settled = !unsettled.contains(k.a) && !unsettled.contains(k.b);
    if (!open || (settled && then.states[i] == AlignmentState::published)) continue;
    k.state = AlignmentState::candidate;
    held.push_back(i);
  }
  MergeResult merged = merge_spoken(std::move(spoken), contacts);
  for (const std::size_t i : held) {
    merged.states[i] = AlignmentState::verified;
    merged.contradicted_by[i] = then.contradicted_by[i];
  }
  return merged;
}

/// Sets what would be added to each component if all provisional alignments were merged. Adds nothing to a component
/// that would lose sessions by it.
void AlignmentBook::add_provisional(std::vector<Component>& components, const Contacts& contacts) const {
  const auto provisional = [](const Alignment& k) { return k.state == AlignmentState::provisional; };
  if (std::none_of(alignments_.begin(), alignments_.end(), provisional)) return;
  const MergeResult then = merge(contacts, Waiting::provisional);
  std::map<SessionId, const Component*> comes_to;
  for (const Component& whole : then.components)
    for (const Placement& p : whole.placements) comes_to[p.session] = &whole;
  for (Component& part : components) {
    const Component& whole = *comes_to.at(part.id);
    if (std::any_of(part.placements.begin(), part.placements.end(),
                    [&](const Placement& p) { return comes_to.at(p.session) != &whole; }))
      continue;
    ProvisionalPlacement held{.probability = 1};
    for (std::size_t i = 0; i < alignments_.size(); ++i) {
      const Alignment& k = alignments_[i];
      if (!provisional(k) || then.states[i] != AlignmentState::published || comes_to.at(k.a) != &whole) continue;
      held.probability = std::min(held.probability, k.evidence.probability);
      held.awaited_m = std::max(held.awaited_m, k.evidence.awaited_m);
    }
    const Pose T_part_whole = placement_in(whole, part.id)->T_component_session.inverse();
    for (const Placement& p : whole.placements) {
      if (placement_in(part, p.session)) continue;
      held.session = p.session;
      held.T_component_session = orthonormalised(T_part_whole * p.T_component_session);
      part.provisional.push_back(held);
    }
  }
}

}  // namespace headframe
