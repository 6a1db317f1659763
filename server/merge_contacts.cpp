// Sessions that others would bring together: before maps merge, each pair of sessions that would come to lie on each
// other is looked at where it meets. Exact copies of a drift pass every test of their own; what lies around them in a
// third session's map tells them apart.

#include <Eigen/Geometry>
#include <algorithm>

#include "server/merge_state.hpp"

namespace headframe {
namespace {

constexpr double same_m = 1, same_rad = 0.03;  // drift between one update of the atlas and the next
constexpr double growth = 1.25;                // of the keyframes that speak: worth another look
constexpr std::size_t placements_kept = 4;     // of a pair
// Of the points at one place. In simulated mines 294 right placements, up to 1.5 m off, had 0.002 and less; 480 of 528
// wrong ones had more than this.
constexpr double contradiction = 0.015;

bool near(const Session& a, const Session& b, const Pose& T_a_b, double reach_m) {
  Eigen::AlignedBox3d box;
  for (const Keyframe& k : a.keyframes) box.extend(k.T_local_sensor.translation());
  if (box.isEmpty()) return false;
  const Eigen::AlignedBox3d reach(box.min().array() - reach_m, box.max().array() + reach_m);
  return std::any_of(b.keyframes.begin(), b.keyframes.end(), [&](const Keyframe& k) {
    const Eigen::Vector3d p = T_a_b * k.T_local_sensor.translation();
    return reach.contains(p) && std::any_of(a.keyframes.begin(), a.keyframes.end(), [&](const Keyframe& other) {
             return (other.T_local_sensor.translation() - p).squaredNorm() < reach_m * reach_m;
           });
  });
}

/// Where it is most; of the first place alone when that was too bad to go on.
double violation_of(const SeenContact& seen) {
  const Evidence& e = seen.judgement.evidence;
  return std::max(e.worst_place_violation, e.freespace_violation);
}

}  // namespace

SeenContact* MergePipeline::State::seen_contact(const Nearing& n) {
  const auto found = contacts.find({n.a, n.b});
  if (found == contacts.end()) return nullptr;
  const auto seen = std::find_if(found->second.begin(), found->second.end(), [&](const SeenContact& c) {
    return !differ(c.T_a_b, n.T_a_b, sessions.at(n.b).middle(), same_m, same_rad);
  });
  return seen == found->second.end() ? nullptr : &*seen;
}

std::optional<Contact> MergePipeline::State::known_contact(const Nearing& n) {
  if (!near(sessions.at(n.a), sessions.at(n.b), n.T_a_b, JudgeConfig{}.meet_m)) return std::nullopt;
  const SeenContact* seen = seen_contact(n);
  return seen ? seen->contact : Contact::unknown;
}

MergeResult MergePipeline::State::merge(const Contacts& asked) const {
  std::vector<SessionId> ids;
  for (const auto& [id, session] : sessions) ids.push_back(id);
  std::vector<Alignment> spoken = alignments;
  for (Alignment& alignment : spoken)  // one whose session is set aside says nothing
    if (!sessions.contains(alignment.a) || !sessions.contains(alignment.b)) alignment.state = AlignmentState::candidate;
  return merge_sessions(ids, spoken, {}, anchors, asked);
}

std::optional<Objection> MergePipeline::State::objection_of(
    const std::optional<std::pair<SessionId, SessionId>>& pair) const {
  if (!pair) return std::nullopt;
  Objection out{pair->first, pair->second, 0};
  for (const SeenContact& seen : contacts.at(*pair)) out.violation = std::max(out.violation, violation_of(seen));
  return out;
}

/// True: something was found that was not known. Clouds that can be had are asked for first, one contact's at a time.
bool MergePipeline::State::look_at(const Nearing& n, CloudSource& clouds, AttemptReport& report) {
  clouds.working_on(n.a, n.b);
  const Laid pair = laid(n.a, n.b);
  const Pose T_0 = by_ids(pair, n.T_a_b);
  Case now = make_case(pair.a, pair.b, {T_0, 0, {}}, clouds);
  now.hypothesis.place_b = middle_of_overlap(now);
  const std::size_t stands = now.a.stored.size() + now.b.stored.size();
  SeenContact* before = seen_contact(n);
  if (before && static_cast<double>(stands) <= growth * static_cast<double>(before->stands)) return false;
  if (const auto wanted = wanted_to_look(pair, now); !before && !wanted.empty()) {
    if (report.wanted.empty()) report.wanted = wanted;
    return false;
  }
  SeenContact seen{n.T_a_b, stands, Contact::none, {}, before && before->recorded};
  if (!now.a.stored.empty() && !now.b.stored.empty()) {
    Judgement judged =
        judge_again(scene(pair.a, now.a.stored, clouds), scene(pair.b, now.b.stored, clouds), T_0, judge_config());
    compare_descriptors({sessions[pair.a].keyframes, sessions[pair.b].keyframes}, judged);
    weigh(judged);
    seen.judgement = by_ids(pair, judged);
    // Where it lies is known from the others: look-alikes elsewhere, and a runner-up, cast no doubt on it.
    if (violation_of(seen) >= contradiction)
      seen.contact = Contact::contradicts;
    else if (judged.evidence.probability >= config.accept_probability && agrees(n.T_a_b, seen.judgement.T_a_b, {}))
      seen.contact = Contact::agrees;
  }
  auto& kept = contacts[{n.a, n.b}];
  const bool news = !before || before->contact != seen.contact;
  if (before)
    *before = std::move(seen);
  else
    kept.push_back(std::move(seen));
  return news;
}

/// Only what did come to lie in one component: an agreement under an alignment that others contradict says nothing.
bool MergePipeline::State::record_agreeing(const MergeResult& merged, AttemptReport& report) {
  bool news = false;
  for (const Component& component : merged.components)
    for (const Placement& a : component.placements)
      for (const Placement& b : component.placements) {
        if (a.session >= b.session) continue;
        SeenContact* seen =
            seen_contact({a.session, b.session, a.T_component_session.inverse() * b.T_component_session});
        if (!seen || seen->contact != Contact::agrees || seen->recorded) continue;
        seen->recorded = true;
        const Alignment* known = find(a.session, b.session);
        const bool spoken_for = known && (known->ruling != Ruling::none || known->state == AlignmentState::verified ||
                                          known->state == AlignmentState::published);
        if (spoken_for) continue;
        record({a.session, b.session}, seen->judgement, std::nullopt, false, report);
        news = true;
      }
  return news;
}

void MergePipeline::State::look_at_contacts(CloudSource& clouds, AttemptReport& report) {
  const Stopwatch watch(report.times.verification_ms);
  for (auto& [pair, kept] : contacts)  // not in between: what was found is not asked for twice, so this ends
    if (kept.size() > placements_kept)
      kept.erase(kept.begin(), kept.end() - static_cast<std::ptrdiff_t>(placements_kept));
  for (bool news = true; news;) {
    std::vector<Nearing> asked;
    const MergeResult merged = merge([&](SessionId a, SessionId b, const Pose& T_a_b) {
      const Nearing nearing{a, b, T_a_b};
      const auto known = known_contact(nearing);
      if (known) asked.push_back(nearing);
      return known.value_or(Contact::none);
    });
    news = false;
    for (const Nearing& nearing : asked) news |= look_at(nearing, clouds, report);
    news = news || record_agreeing(merged, report);
  }
}

}  // namespace headframe
