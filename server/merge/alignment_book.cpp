#include "server/merge/alignment_book.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/atlas/rivals.hpp"
#include "server/merge/alignment_edges.hpp"
#include "server/merge/frozen_places.hpp"
#include "server/session/same_placement.hpp"
#include "server/support/stopwatch.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

constexpr double awaited_news_m = 5;

}  // namespace

void AlignmentBook::restore(std::vector<Alignment> alignments, std::vector<DecisionRecord> decisions,
                            std::vector<SessionId> anchors) {
  const SessionFrames& frames = sessions_.frames();
  alignments_ = std::move(alignments);
  anchors_ = std::move(anchors);
  by_pair_.clear();
  for (std::size_t i = 0; i < alignments_.size(); ++i) {
    alignments_[i] = frames.local(alignments_[i]);
    by_pair_[{alignments_[i].a, alignments_[i].b}] = i;
  }
  for (DecisionRecord& record : decisions)
    if (const Alignment* of = find(record.alignment)) record.T_a_b = frames.local(of->a, of->b, record.T_a_b);
  decisions_.restore(std::move(decisions));
  decisions_.rule(alignments_);
}

Alignment* AlignmentBook::find(SessionId one, SessionId other) {
  const auto found = by_pair_.find(std::minmax(one, other));
  return found == by_pair_.end() ? nullptr : &alignments_[found->second];
}

const Alignment* AlignmentBook::find(AlignmentId id) const {
  const auto found = std::lower_bound(alignments_.begin(), alignments_.end(), id,
                                      [](const Alignment& k, AlignmentId of) { return k.id < of; });
  return found == alignments_.end() || found->id != id ? nullptr : &*found;
}

const Alignment* AlignmentBook::find(SessionId one, SessionId other) const {
  const auto found = by_pair_.find(std::minmax(one, other));
  return found == by_pair_.end() ? nullptr : &alignments_[found->second];
}

std::map<AlignmentId, Pose> AlignmentBook::published() const {
  std::map<AlignmentId, Pose> out;
  for (const Alignment& k : alignments_)
    if (k.state == AlignmentState::published) out.emplace(k.id, k.T_a_b);
  return out;
}

bool AlignmentBook::live(SessionId one, SessionId other) const {
  const Alignment* known = find(one, other);
  return known && (known->state != AlignmentState::rejected || known->ruling != Ruling::none);
}

std::set<SessionId> AlignmentBook::aligned_with(SessionId id) const {
  std::set<SessionId> out;
  for (const Alignment& k : alignments_)
    if ((k.a == id || k.b == id) && live(k.a, k.b)) out.insert(k.a == id ? k.b : k.a);
  return out;
}

AlignmentState AlignmentBook::state_of(const OrderedPair& pair, const Judgement& best, const Alignment* known,
                                       bool waits) const {
  const Evidence& e = best.evidence;
  const bool stands = known && known->state == AlignmentState::published &&
                      same_placement(best.T_a_b, known->T_a_b, sessions_.at(known->b).middle(), same_as_rival);
  if (convinces(e, config_)) {
    if (stands) return AlignmentState::verified;
    if (!sessions_.may_merge(pair) || waits) return AlignmentState::candidate;
    return awaiting_state(e);
  }
  return calibrated(e, config_) >= config_.candidate_probability ? AlignmentState::candidate : AlignmentState::rejected;
}

void AlignmentBook::record(const OrderedPair& pair, const Judgement& judged, const std::optional<Pose>& T_a_b_runner_up,
                           bool waits, AttemptReport& report) {
  const auto [a, b] = std::minmax(pair.a, pair.b);
  Judgement best = by_ids(pair, judged);
  best.evidence.path_m = sessions_.at(a).path_m() + sessions_.at(b).path_m();
  best.evidence.awaited_m = sessions_.path_awaited_m(pair, judged.T_a_b, judged.evidence);
  const auto T_runner_up = T_a_b_runner_up ? std::optional(by_ids(pair, *T_a_b_runner_up)) : std::nullopt;
  Alignment* known = find(a, b);
  AlignmentState now = state_of(pair, best, known, waits);
  best.evidence.probability = calibrated(best.evidence, config_);
  if (!known) {
    const AlignmentId id = alignments_.empty() ? 1 : alignments_.back().id + 1;
    by_pair_[{a, b}] = alignments_.size();
    alignments_.push_back({id, a, b, now, best.T_a_b, best.evidence, now, Ruling::none, T_runner_up});
    alignments_.back().changes = best.changes;
    report.changed.push_back(alignments_.back());
    if (waits) wait_for_clouds_.insert(id);
    return;
  }
  if (waits)
    wait_for_clouds_.insert(known->id);
  else
    wait_for_clouds_.erase(known->id);
  // An alignment on which the operator has decided stays as it is until there is one that could be published.
  if (known->ruling != Ruling::none && now != AlignmentState::verified) return;
  const bool refused_once =
      decisions_.proposal(known->id, best.T_a_b, best.evidence.seen_points) == Proposal::as_candidate;
  if (refused_once && (now == AlignmentState::verified || now == AlignmentState::provisional))
    now = AlignmentState::candidate;
  known->verdict = now;
  if (known->state == AlignmentState::published && now != AlignmentState::verified) now = AlignmentState::retracted;
  if (known->state == AlignmentState::retracted && judged.evidence.probability < config_.candidate_probability)
    now = AlignmentState::retracted;
  const bool news = known->state != now ||
                    !same_placement(known->T_a_b, best.T_a_b, Eigen::Vector3d::Zero(), same_numbers) ||
                    std::abs(known->evidence.awaited_m - best.evidence.awaited_m) > awaited_news_m;
  known->state = now;
  known->T_a_b = best.T_a_b;
  known->T_a_b_runner_up = T_runner_up;
  known->evidence = best.evidence;
  known->changes = best.changes;
  known->ruling = decisions_.ruling(*known);
  if (news) report.changed.push_back(*known);
}

Result<void> AlignmentBook::decide(AlignmentId id, Decision decision, AttemptReport& report) {
  const Alignment* known = find(id);
  if (!known)
    return failure(ErrorCode::not_found,
                   "there is no alignment " + std::to_string(id) + "; the atlas lists those there are");
  Alignment* found = find(known->a, known->b);
  const auto record = decisions_.decide(*found, decision);
  if (!record) return tl::unexpected(record.error());
  if (!*record) return {};
  report.decided.push_back(**record);
  if (const auto T_confirmed = decisions_.confirmed_at(id); T_confirmed && decision == Decision::undo)
    found->T_a_b = *T_confirmed;
  found->ruling = decisions_.ruling(*found);
  found->state = decided_state(*found);
  report.changed.push_back(*found);
  return {};
}

Result<bool> AlignmentBook::anchor(SessionId id) {
  const FrozenSessions& frozen = sessions_.frozen();
  for (const Component& component : atlas_.components)
    if (placement_in(component, id) && frozen.contains(component.id) && !frozen.contains(id))
      return failure(ErrorCode::refused, "the map is anchored to session " + std::to_string(component.id) +
                                             ", which is frozen: thaw it, or freeze this one and choose it then");
  if (!anchors_.empty() && anchors_.back() == id) return false;
  std::erase(anchors_, id);
  anchors_.push_back(id);
  return true;
}

std::vector<Alignment> AlignmentBook::wake(SessionId id) {
  std::vector<Alignment> changed;
  for (Alignment& k : alignments_) {
    if (k.a != id && k.b != id) continue;
    const AlignmentState was = std::exchange(k.state, decided_state(k));
    if (k.state != was) changed.push_back(k);
  }
  return changed;
}

AlignmentBook::Moved AlignmentBook::moved(SessionId id, const Mover& mover) {
  Moved out;
  for (Alignment& k : alignments_) {
    if ((k.a != id && k.b != id) || (!has_placement(k) && k.ruling == Ruling::none)) continue;
    const Alignment was = k;
    if (!sessions_.contains(k.a == id ? k.b : k.a) && k.verdict == AlignmentState::verified) {
      k.verdict = AlignmentState::candidate;
      k.state = decided_state(k);
    }
    k.T_a_b = orthonormalised(mover(was, was.T_a_b));
    if (was.T_a_b_runner_up) k.T_a_b_runner_up = orthonormalised(mover(was, *was.T_a_b_runner_up));
    const Pose T_now_was = k.T_a_b * was.T_a_b.inverse();
    if (k.a == id)
      for (Change& change : k.changes) change.p_a = T_now_was * change.p_a;
    k.evidence.path_m = 0;  // so that the pair is judged again as a whole
    out.alignments.push_back(k);
    const auto records = decisions_.move(k.id, [&](const Pose& T) { return orthonormalised(mover(was, T)); });
    out.decisions.insert(out.decisions.end(), records.begin(), records.end());
  }
  return out;
}

MergeResult AlignmentBook::merge_spoken(std::vector<Alignment> spoken, const Contacts& contacts) const {
  std::vector<SessionId> ids;
  for (const auto& [id, session] : sessions_.all()) ids.push_back(id);
  for (Alignment& k : spoken) {
    if (!sessions_.contains(k.a) || !sessions_.contains(k.b))
      k.state = AlignmentState::candidate;  // an alignment whose session is set aside has no effect
    else if (!sessions_.at_one_site(k.a, k.b) && k.ruling == Ruling::none)
      k.state = AlignmentState::rejected;  // across sites only the operator's decisions count
  }
  FrozenSessions frozen;
  for (const auto& [id, held] : sessions_.frozen()) frozen[id] = local(held, sessions_.frames());
  const auto meet = [this](const Alignment& k) {
    return where_they_meet(sessions_.at(k.a), sessions_.at(k.b), k.T_a_b);
  };
  return merge_sessions(ids, spoken, {}, anchors_, contacts, frozen, meet,
                        rivalled(spoken, config_, config_.look_alikes, {ids.begin(), ids.end()}, contacts));
}

MergeResult AlignmentBook::merge(const Contacts& contacts, Waiting waiting) const {
  std::vector<Alignment> spoken = alignments_;
  for (Alignment& k : spoken) {
    const bool taken = waiting == Waiting::all           ? may_come(k)
                       : waiting == Waiting::provisional ? k.state == AlignmentState::provisional
                                                         : false;
    if (taken) k.state = AlignmentState::verified;
  }
  return merge_spoken(std::move(spoken), contacts);
}

void AlignmentBook::update_atlas(const Contacts& contacts,
                                 const std::function<Objection(const std::pair<SessionId, SessionId>&)>& objection,
                                 AttemptReport& report) {
  const Stopwatch watch(report.times.atlas_ms);
  const MergeResult merged = merge_undisputed(contacts);
  for (std::size_t i = 0; i < alignments_.size(); ++i) {
    Alignment& alignment = alignments_[i];
    const auto& by = merged.contradicted_by[i];
    const bool news = alignment.state != merged.states[i] || alignment.objection.has_value() != by.has_value();
    alignment.state = merged.states[i];
    alignment.objection = by ? std::optional(objection(*by)) : std::nullopt;
    if (news) report.changed.push_back(alignment);
  }
  // Of several changes to one alignment only the last is stored.
  std::map<AlignmentId, Alignment> last;
  for (const Alignment& alignment : report.changed) last[alignment.id] = alignment;
  report.changed.clear();
  for (auto& [id, alignment] : last) report.changed.push_back(*find(alignment.a, alignment.b));
  std::vector<Component> components = merged.components;
  add_provisional(components, contacts);
  note_moved_sessions(components, report);
  atlas_.components = std::move(components);
  if (report.atlas_changed) ++atlas_.revision;
}

void AlignmentBook::note_moved_sessions(const std::vector<Component>& now, AttemptReport& report) const {
  std::map<SessionId, std::pair<SessionId, Pose>> before;
  for (const Component& component : atlas_.components)
    for (const Placement& p : component.placements) before[p.session] = {component.id, p.T_component_session};
  for (const Component& component : now)
    for (const Placement& p : component.placements) {
      const auto was = before.find(p.session);
      const bool alone = was == before.end() && component.placements.size() == 1;  // a new session moves no transform
      if (alone) continue;
      report.atlas_changed |=
          was == before.end() || was->second.first != component.id ||
          !same_placement(was->second.second, p.T_component_session, Eigen::Vector3d::Zero(), same_numbers);
    }
  const auto provisional_of = [](const std::vector<Component>& components) {
    std::map<SessionId, std::vector<ProvisionalPlacement>> all;
    for (const Component& component : components)
      if (!component.provisional.empty()) all[component.id] = component.provisional;
    return all;
  };
  report.provisional_changed = provisional_of(atlas_.components) != provisional_of(now);
}

void AlignmentBook::next_revision(AttemptReport& report) {
  ++atlas_.revision;
  report.atlas_changed = true;
}

AttemptReport AlignmentBook::given_out(AttemptReport report) {
  const SessionFrames& frames = sessions_.frames();
  for (Alignment& alignment : report.changed) alignment = frames.given_out(alignment);
  for (PairTrace& trace : report.traces) {
    const auto give_out = [&](Pose& T_a_b) { T_a_b = frames.given_out(trace.a, trace.b, T_a_b); };
    for (PairTrace::Proposal& proposal : trace.proposed) give_out(proposal.T_a_b);
    for (Pose& T_a_b : trace.screened) give_out(T_a_b);
    for (Judgement& judged : trace.judged) give_out(judged.T_a_b);
  }
  for (DecisionRecord& record : report.decided) {
    const Alignment* of = find(record.alignment);
    record.T_a_b = frames.given_out(of->a, of->b, record.T_a_b);
  }
  atlas_given_out_ = frames.given_out(atlas_);
  alignments_given_out_.clear();
  for (const Alignment& alignment : alignments_) alignments_given_out_.push_back(frames.given_out(alignment));
  return report;
}

}  // namespace headframe
