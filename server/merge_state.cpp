#include "server/merge_state.hpp"

#include <algorithm>
#include <cmath>

#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr std::size_t exact_up_to = 20000;   // keyframes of a family; FLANN beyond
constexpr std::size_t asked_of_index = 20;   // nearest keyframes of any session, to see who looks alike ...
constexpr std::size_t keyframes_asked = 30;  // ... for so many keyframes spread over a session
constexpr std::size_t judged_closely = 4;    // hopeful placements of a pair that are judged with all evidence
constexpr std::size_t mb = 1000000;

/// Whether, with all else in its favour, it could neither beat nor cast doubt on what was judged already.
bool hopeless_rival(const Glance& glance, const DescriptorAgreement& agreement, const std::vector<Verdict>& judged) {
  Judgement rival{RegistrationStatus::converged, glance.place.registration.T_target_source, {}};
  compare_descriptors(agreement, rival);
  constexpr double doubt = 0.1;  // of the odds that would leave two placements untold apart
  return std::any_of(judged.begin(), judged.end(), [&](const Verdict& v) {
    Evidence e = v.judgement.evidence;
    e.runner_up = best_probability(glance, rival.evidence);
    return runner_up_share(e) < doubt;
  });
}

/// All speaks for it but that the mine repeats itself: where it is wrong, a copy of the rock lies there.
bool is_copy(const Judgement& judged) { return judged.evidence.probability_if_unique >= 0.5; }

/// Better glances first: fewer contradictions, more points that fit, and descriptors that agree along the path. One
/// place of a mine that repeats itself fits at many others.
double promise(const Glance& glance, const DescriptorAgreement& agreement) {
  const Registration& r = glance.place.registration;
  const double alike = agreement.at(r.T_target_source).cautious();
  return std::max(0.0, r.inlier_fraction - 20 * glance.place.between().violation()) * alike * alike;
}

}  // namespace

MergePipeline::State::State(const MergeConfig& c)
    : config(c),
      finder({.seats = {.coherent = static_cast<std::size_t>(c.hypotheses)},
              .walls_bytes = mb * static_cast<std::size_t>(c.walls_mb),
              .threads = c.threads}),
      prepared(mb * static_cast<std::size_t>(c.clouds_mb), c.threads),
      places(mb * static_cast<std::size_t>(c.places_mb), c.threads, JudgeConfig{}.place, prepared),
      far_places(mb * static_cast<std::size_t>(c.places_mb) / 8, c.threads, far_places_config(), prepared) {}

JudgeConfig MergePipeline::State::judge_config() const {
  JudgeConfig judge;
  judge.threads = config.threads;
  return judge;
}

std::vector<SessionId> MergePipeline::State::partners(SessionId id) const {
  const Session& self = sessions.at(id);
  std::map<SessionId, int> alike;
  for (const auto& [other, session] : sessions)
    if (other != id && session.family == self.family) alike[other] = 0;
  if (alike.size() > 1) {
    const std::size_t step = std::max<std::size_t>(1, self.keyframes.size() / keyframes_asked);
    for (std::size_t i = 0; i < self.keyframes.size(); i += step) {
      const auto& q = self.keyframes[i].descriptor.q;
      const auto index = indices.find({self.family, q.size()});
      if (index == indices.end()) continue;
      for (const PlaceNeighbour& n : index->second->nearest(q, asked_of_index))
        if (const auto found = alike.find(n.keyframe.session); found != alike.end()) ++found->second;
    }
  }
  std::vector<SessionId> order;
  order.reserve(alike.size());
  for (const auto& [other, count] : alike) order.push_back(other);
  std::stable_sort(order.begin(), order.end(), [&](SessionId x, SessionId y) { return alike.at(x) > alike.at(y); });
  return order;
}

PlaceRequest MergePipeline::State::place_at(SessionId id, std::size_t keyframe) const {
  const Session& session = sessions.at(id);
  return {id, session.keyframes, session.path_to_m, keyframe};
}

Scene MergePipeline::State::scene(SessionId id, std::vector<Stand> stands, CloudSource& clouds) {
  return {std::move(stands), [this, id, &clouds](std::span<const std::size_t> keyframes) {
            std::vector<PlaceRequest> asked;
            asked.reserve(keyframes.size());
            for (const std::size_t k : keyframes) asked.push_back(place_at(id, k));
            return places.get(asked, clouds);
          }};
}

bool MergePipeline::State::prepare_ahead(CloudSource& clouds) {
  for (auto& [id, session] : sessions) {
    const auto known = [&, &kept = session](std::size_t k) {  // what a place sees is driven through, or all there is
      return kept.complete || kept.path_to_m[k] + JudgeConfig{}.place.window_m < kept.path_m();
    };
    clouds.working_on(id, id);
    if (session.prepared < session.keyframes.size() && known(session.prepared)) {
      const PlaceRequest request = place_at(id, session.prepared++);
      places.get({&request, 1}, clouds);
      return true;
    }
    if (may_merge(id) && !self_likeness_known(id, clouds)) {
      self_aliases(id, clouds);
      return true;
    }
  }
  return false;
}

std::vector<Glance> MergePipeline::State::glance_at(SessionId a, SessionId b, const std::vector<Case>& cases,
                                                    CloudSource& clouds) {
  const JudgeConfig judge = judge_config();
  std::vector<std::size_t> meet;  // cases
  std::vector<PlaceRequest> asked;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& c = cases[i];
    const auto meeting = first_meeting(c.a.stored, c.b.stored, c.hypothesis.T_a_b, c.hypothesis.place_b, judge);
    if (!meeting) continue;
    meet.push_back(i);
    asked.push_back(place_at(a, meeting->keyframe_a));
    asked.push_back(place_at(b, meeting->keyframe_b));
  }
  const std::vector<PlacePtr> at = places.get(asked, clouds);
  std::vector<Pose> T(meet.size());
  std::vector<std::pair<double, std::size_t>> order(meet.size());  // the likeliest first, ties as they were proposed
  for_blocks(meet.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    T[i] = cases[meet[i]].hypothesis.T_a_b;
    order[i] = {-screen(*at[2 * i], *at[2 * i + 1], T[i]), i};
  });
  std::sort(order.begin(), order.end());
  if (order.size() > judge.screened_fully) order.resize(judge.screened_fully);
  std::vector<Glance> glances(cases.size());
  for_blocks(order.size(), 1, config.threads, [&](std::size_t k, std::size_t, std::size_t) {
    const std::size_t i = order[k].second;
    glances[meet[i]] = glance(at[2 * i], at[2 * i + 1], T[i], judge);
  });
  return glances;
}

void compare_descriptors(const DescriptorAgreement& agreement, Judgement& judgement) {
  const Agreement found = agreement.at(judgement.T_a_b);
  judgement.evidence.descriptors_compared = found.count;
  judgement.evidence.descriptors_alike = found.mean();
}

std::vector<Verdict> MergePipeline::State::judge_cases(SessionId a, SessionId b, const std::vector<Case>& cases,
                                                       CloudSource& clouds, bool all, AttemptReport& report) {
  const double self = self_aliases(a, clouds) + self_aliases(b, clouds);
  std::vector<Glance> glances;
  {
    const Stopwatch watch(report.times.registration_ms);
    glances = glance_at(a, b, cases, clouds);
  }
  const Stopwatch watch(report.times.verification_ms);
  const DescriptorAgreement agreement(sessions[a].keyframes, sessions[b].keyframes);
  for (const Glance& g : glances)
    if (g.hopeful && !report.traces.empty())
      report.traces.back().screened.push_back(by_ids({a, b}, g.place.registration.T_target_source));
  std::vector<std::size_t> order;
  std::vector<double> promises(glances.size(), 0);
  for (std::size_t i = 0; i < glances.size(); ++i) {
    if (!glances[i].hopeful) continue;
    order.push_back(i);
    promises[i] = promise(glances[i], agreement);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return promises[i] > promises[j]; });
  std::vector<Verdict> verdicts;
  std::vector<std::size_t> judged_cases;
  for (const std::size_t i : order) {
    const PlaceCheck& place = glances[i].place;
    const bool known = std::any_of(verdicts.begin(), verdicts.end(), [&](const Verdict& v) {
      return !differ(v.judgement.T_a_b, place.registration.T_target_source, place.p_b, same_placement_m,
                     same_placement_rad);
    });
    if (known || verdicts.size() == judged_closely || (!all && hopeless_rival(glances[i], agreement, verdicts)))
      continue;
    const Case& c = cases[i];
    Verdict verdict{judge(scene(a, c.a.stored, clouds), scene(b, c.b.stored, clouds), glances[i], judge_config()),
                    place.p_b};
    Evidence& e = verdict.judgement.evidence;
    e.support = c.hypothesis.score;
    compare_descriptors(agreement, verdict.judgement);
    e.repetition = repetition();
    e.look_alikes =
        sessions[a].self.look_alikes + sessions[b].self.look_alikes + look_alikes(glances, verdict.judgement.T_a_b);
    weigh(verdict.judgement);
    verdicts.push_back(verdict);
    judged_cases.push_back(i);
  }
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    Verdict& verdict = verdicts[i];
    Evidence& e = verdict.judgement.evidence;
    const Case& c = cases[judged_cases[i]];
    e.aliases = self + static_cast<double>(std::count_if(verdicts.begin(), verdicts.end(), [&](const Verdict& v) {
                  return is_copy(v.judgement) && differ(v.judgement.T_a_b, verdict.judgement.T_a_b, verdict.p_b,
                                                        same_placement_m, same_placement_rad);
                }));
    weigh(verdict.judgement);
    if (e.probability < config.accept_probability) {
      verdict.wanted = wanted_to_tell({a, b}, c, verdict);
      continue;
    }
    look_farther({a, b}, c, verdict, clouds);
    if (e.repetition < copies_known) verdict.wanted.clear();  // worth looking at what is here, not worth asking for
    weigh(verdict.judgement);
  }
  std::stable_sort(verdicts.begin(), verdicts.end(), [](const Verdict& v, const Verdict& w) {
    return v.judgement.evidence.probability > w.judgement.evidence.probability;
  });
  return verdicts;
}

Judgement MergePipeline::State::judge_placement(const Laid& pair, const Pose& T_a_b, CloudSource& clouds) {
  const Case now = make_case(pair.a, pair.b, {T_a_b, 0, {}}, clouds);
  if (now.a.stored.empty() || now.b.stored.empty()) return {};
  Judgement out =
      judge_again(scene(pair.a, now.a.stored, clouds), scene(pair.b, now.b.stored, clouds), T_a_b, judge_config());
  compare_descriptors({sessions[pair.a].keyframes, sessions[pair.b].keyframes}, out);
  out.evidence.aliases = self_aliases(pair.a, clouds) + self_aliases(pair.b, clouds);
  out.evidence.repetition = repetition();
  out.evidence.look_alikes = sessions[pair.a].self.look_alikes + sessions[pair.b].self.look_alikes;
  weigh(out);
  return out;
}

Alignment* MergePipeline::State::find(SessionId one, SessionId other) {
  const auto [a, b] = std::minmax(one, other);
  for (Alignment& alignment : alignments)
    if (alignment.a == a && alignment.b == b) return &alignment;
  return nullptr;
}

void MergePipeline::State::index_keyframe(SessionId id, const Keyframe& keyframe) {
  const FamilyId& family = sessions[id].family;
  const auto& q = keyframe.descriptor.q;
  if (q.empty()) return;
  auto& index = indices[{family, q.size()}];
  if (!index) index = make_exact_index(q.size());
  if (index->size() == exact_up_to) {
    index = make_flann_index(q.size());
    for (const auto& [session_id, session] : sessions)
      if (session.family == family)
        for (const Keyframe& k : session.keyframes)
          if (k.descriptor.q.size() == q.size()) index->add({session_id, k.sequence}, k.descriptor.q);
  }
  index->add({id, keyframe.sequence}, q);
}

}  // namespace headframe
