#include "server/merge/consistency_check.hpp"

#include <algorithm>

#include "server/session/same_placement.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {
namespace {

constexpr double growth = 1.25;             // of the keyframes used: from here on a pair is judged again
constexpr std::size_t placements_kept = 4;  // for each pair
// Share of violated points at one place that counts as a contradiction. In simulated mines 294 right placements, up to
// 1.5 m off, had 0.002 and less; 480 of 528 wrong ones had more than this threshold.
constexpr double contradiction = 0.015;

/// The violation of the worst place, or of the overlap. (If the first place was too bad to go on, there is only that.)
double violation_of(const Evidence& e) { return std::max(worst_place_contradiction(e), freespace_contradiction(e)); }

}  // namespace

bool ConsistencyCheck::meet(const ImpliedPlacement& placement) const {
  const Session &a = sessions_.at(placement.a), &b = sessions_.at(placement.b);
  const double reach_m = JudgeConfig{}.meet_m;
  if (a.keyframes.empty() || b.keyframes.empty()) return false;
  const Eigen::AlignedBox3d reach(a.box.min().array() - reach_m, a.box.max().array() + reach_m);
  const double radius_b_m = b.box.diagonal().norm() / 2;
  if (reach.exteriorDistance(placement.T_a_b * b.box.center()) > radius_b_m) return false;
  return std::any_of(b.keyframes.begin(), b.keyframes.end(), [&](const Keyframe& k) {
    const Eigen::Vector3d p = placement.T_a_b * k.T_local_sensor.translation();
    return reach.contains(p) && a.distance_m(p) < reach_m;
  });
}

ConsistencyCheck::SeenContact* ConsistencyCheck::seen(const ImpliedPlacement& placement) {
  const auto found = contacts_.find({placement.a, placement.b});
  if (found == contacts_.end()) return nullptr;
  const Eigen::Vector3d middle = sessions_.at(placement.b).middle();
  const auto here = std::find_if(found->second.begin(), found->second.end(), [&](const SeenContact& c) {
    return same_placement(c.T_a_b, placement.T_a_b, middle, same_contact);
  });
  return here == found->second.end() ? nullptr : &*here;
}

std::optional<Contact> ConsistencyCheck::known_contact(const ImpliedPlacement& placement) {
  if (!meet(placement)) return std::nullopt;
  const SeenContact* known = seen(placement);
  return known ? known->contact : Contact::unknown;
}

Objection ConsistencyCheck::objection(const std::pair<SessionId, SessionId>& pair) const {
  Objection out{pair.first, pair.second, 0};
  for (const SeenContact& contact : contacts_.at(pair)) out.violation = std::max(out.violation, contact.violation);
  return out;
}

void ConsistencyCheck::forget(SessionId id) {
  std::erase_if(contacts_, [id](const auto& entry) { return entry.first.first == id || entry.first.second == id; });
}

ConsistencyCheck::SeenContact ConsistencyCheck::judged(const ImpliedPlacement& placement, const OrderedPair& pair,
                                                       const Case& at, CloudSource& clouds) const {
  SeenContact out{.T_a_b = placement.T_a_b,
                  .keyframes = at.a.stored.size() + at.b.stored.size(),
                  .whole = sessions_.have_ended(pair)};
  if (at.a.stored.empty() || at.b.stored.empty()) return out;
  out.judgement = by_ids(pair, verifier_.judge_contact(pair, at, clouds));
  const Judgement& judged = out.judgement;
  out.violation = violation_of(judged.evidence);
  // Rock of another place contradicts wherever the registration ends: at what was implied, too.
  if (out.violation >= contradiction) out.violation = std::min(out.violation, verifier_.violation_at(pair, at, clouds));
  if (out.violation >= contradiction)
    out.contact = Contact::contradicts;
  else if (judged.evidence.probability >= config_.accept_probability && agrees(placement.T_a_b, judged.T_a_b, {}))
    out.contact = Contact::agrees;
  return out;
}

/// Returns true if something new was found.
bool ConsistencyCheck::look_at(const ImpliedPlacement& placement, const Attempt& attempt) {
  attempt.clouds.working_on(placement.a, placement.b);
  const OrderedPair pair = sessions_.ordered(placement.a, placement.b);
  Case at = requests_.make_case(pair.a, pair.b, {.T_a_b = by_ids(pair, placement.T_a_b)}, attempt.clouds);
  at.hypothesis.place_b = middle_of_overlap(at);
  SeenContact* before = seen(placement);
  const auto speak = static_cast<double>(at.a.stored.size() + at.b.stored.size());
  // When both sessions have ended they are judged once more, so that the result does not depend on when that was.
  if (before && (before->whole || !sessions_.have_ended(pair)) &&
      speak <= growth * static_cast<double>(before->keyframes))
    return false;
  if (const auto wanted = requests_.clouds_for_screening(pair, at); !before && !wanted.empty()) {
    if (attempt.report.wanted.empty()) attempt.report.wanted = wanted;
    return false;
  }
  SeenContact now = judged(placement, pair, at, attempt.clouds);
  if (const auto more = requests_.clouds_for_contact(pair, at); now.contact == Contact::none && !more.empty()) {
    if (attempt.report.wanted.empty()) attempt.report.wanted = more;
    return false;
  }
  now.recorded = before && before->recorded;
  const bool news = !before || before->contact != now.contact;
  if (before)
    *before = std::move(now);
  else
    contacts_[{placement.a, placement.b}].push_back(std::move(now));
  return news;
}

/// Records only pairs that really came to lie in one component: an agreement that rests on a contradicted alignment
/// proves nothing.
bool ConsistencyCheck::record_agreeing(const MergeResult& merged, AttemptReport& report) {
  bool news = false;
  for (const Component& component : merged.components)
    for (const Placement& a : component.placements)
      for (const Placement& b : component.placements) {
        if (a.session >= b.session) continue;
        SeenContact* contact = seen({a.session, b.session, a.T_component_session.inverse() * b.T_component_session});
        if (!contact || contact->contact != Contact::agrees || contact->recorded) continue;
        contact->recorded = true;
        const Alignment* known = book_.find(a.session, b.session);
        if (!sessions_.at_one_site(a.session, b.session)) continue;
        const bool spoken_for = known && (known->ruling != Ruling::none || known->state == AlignmentState::verified ||
                                          known->state == AlignmentState::published);
        if (spoken_for) continue;
        book_.record({a.session, b.session}, contact->judgement, std::nullopt, false, report);
        news = true;
      }
  return news;
}

void ConsistencyCheck::look_at_contacts(const Attempt& attempt) {
  const Stopwatch watch(attempt.report.times.verification_ms);
  for (auto& [pair, kept] : contacts_) {  // only between rounds, or results would be computed again without end
    if (kept.size() > placements_kept)
      kept.erase(kept.begin(), kept.end() - static_cast<std::ptrdiff_t>(placements_kept));
    // The pair may have been judged by itself since. Agreement with third sessions counts again if only look-alikes
    // spoke against it.
    const Alignment* known = book_.find(pair.first, pair.second);
    if (known && known->evidence.probability_if_unique >= config_.accept_probability)
      for (SeenContact& contact : kept) contact.recorded = false;
  }
  look_while_news(AlignmentBook::Waiting::none, attempt);
  if (book_.anything_may_come()) look_while_news(AlignmentBook::Waiting::all, attempt);
}

/// Checks waiting alignments too (`waiting`), because they may contradict what is about to be published; they are not
/// recorded.
void ConsistencyCheck::look_while_news(AlignmentBook::Waiting waiting, const Attempt& attempt) {
  for (bool news = true; news;) {
    std::vector<ImpliedPlacement> asked;
    const auto contacts = [&](SessionId a, SessionId b, const Pose& T_a_b) {
      const auto known = known_contact({a, b, T_a_b});
      if (known) asked.push_back({a, b, T_a_b});
      return known.value_or(Contact::none);
    };
    const MergeResult merged = book_.merge(contacts, waiting);
    news = false;
    for (const ImpliedPlacement& placement : asked) news |= look_at(placement, attempt);
    if (waiting == AlignmentBook::Waiting::none) news = news || record_agreeing(merged, attempt.report);
  }
}

}  // namespace headframe
