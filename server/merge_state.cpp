#include "server/merge_state.hpp"

#include <algorithm>
#include <cmath>

#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr std::size_t neighbours = 5;        // of each keyframe, in the votes
constexpr std::size_t exact_up_to = 20000;   // keyframes of a family; FLANN beyond
constexpr std::size_t asked_of_index = 20;   // nearest keyframes of any session, to see who looks alike ...
constexpr std::size_t keyframes_asked = 30;  // ... for so many keyframes spread over a session
constexpr std::size_t judged_closely = 4;    // hopeful placements of a pair that are judged with all evidence
constexpr double elsewhere_m = 6, elsewhere_rad = 0.5;  // a session turned or moved less lies where it is
constexpr double same_placement_m = 2, same_placement_rad = 0.12;

float squared_distance(const std::vector<float>& p, const std::vector<float>& q) {
  float sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (p[i] - q[i]) * (p[i] - q[i]);
  return sum;
}

/// Better glances first: fewer contradictions, then more points that fit.
double promise(const Glance& glance) {
  return glance.place.registration.inlier_fraction - 20 * glance.place.between.violation();
}

}  // namespace

MergePipeline::State::State(const MergeConfig& c)
    : config(c),
      finder({.most = static_cast<std::size_t>(c.hypotheses), .threads = c.threads}),
      prepared(static_cast<std::size_t>(c.clouds_kept), c.threads) {}

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
  if (const auto& index = families.at(self.family).index; index && alike.size() > 1) {
    const std::size_t step = std::max<std::size_t>(1, self.keyframes.size() / keyframes_asked);
    for (std::size_t i = 0; i < self.keyframes.size(); i += step)
      for (const PlaceNeighbour& n : index->nearest(self.keyframes[i].descriptor.q, asked_of_index))
        if (const auto found = alike.find(n.keyframe.session); found != alike.end()) ++found->second;
  }
  std::vector<SessionId> order;
  order.reserve(alike.size());
  for (const auto& [other, count] : alike) order.push_back(other);
  std::stable_sort(order.begin(), order.end(), [&](SessionId x, SessionId y) { return alike.at(x) > alike.at(y); });
  return order;
}

std::vector<MatchedPair> MergePipeline::State::match_descriptors(SessionId a, SessionId b) const {
  const auto &of_a = sessions.at(a).keyframes, &of_b = sessions.at(b).keyframes;
  std::vector<MatchedPair> matches;
  for (std::size_t j = 0; j < of_b.size(); ++j) {
    const auto& q = of_b[j].descriptor.q;
    if (q.empty()) continue;
    std::vector<MatchedPair> nearest;
    for (std::size_t i = 0; i < of_a.size(); ++i)
      if (of_a[i].descriptor.q.size() == q.size()) nearest.push_back({i, j, squared_distance(of_a[i].descriptor.q, q)});
    const std::size_t taken = std::min(neighbours, nearest.size());
    std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(taken), nearest.end(),
                      [](const auto& m, const auto& n) {
                        return m.squared_distance < n.squared_distance ||
                               (m.squared_distance == n.squared_distance && m.a < n.a);
                      });
    matches.insert(matches.end(), nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(taken));
  }
  return matches;
}

Case MergePipeline::State::make_case(SessionId a, SessionId b, const Hypothesis& hypothesis, CloudSource& clouds) {
  Case made{hypothesis, {}, {}, {}};
  made.a = clouds_near(a, b, hypothesis.T_a_b, clouds, made.missing);
  made.b = clouds_near(b, a, hypothesis.T_a_b.inverse(), clouds, made.missing);
  return made;
}

/// Clouds of `id` that lie within reach of the other session; what is missing of them and can be had is listed, the
/// nearest first.
std::vector<PlacedCloud> MergePipeline::State::clouds_near(SessionId id, SessionId other, const Pose& T_id_other,
                                                           CloudSource& clouds, std::vector<KeyframeRef>& missing) {
  const double reach_m = JudgeConfig{}.look_m, needed_m = 2.5 * JudgeConfig{}.meet_m;
  std::vector<Eigen::Vector3d> others;
  others.reserve(sessions[other].keyframes.size());
  for (const Keyframe& k : sessions[other].keyframes) others.push_back(T_id_other * k.T_local_sensor.translation());
  std::vector<PlacedCloud> near;
  std::vector<std::pair<double, KeyframeRef>> absent;
  for (const Keyframe& k : sessions[id].keyframes) {
    double squared = reach_m * reach_m;
    for (const auto& p : others) squared = std::min(squared, (k.T_local_sensor.translation() - p).squaredNorm());
    if (squared >= reach_m * reach_m || k.point_count == 0) continue;
    const KeyframeRef ref{id, k.sequence};
    if (auto cloud = prepared.get(ref, clouds))
      near.push_back({k.sequence, k.T_local_sensor, std::move(cloud)});
    else if (std::sqrt(squared) < needed_m && clouds.state(ref) == CloudState::obtainable)
      absent.emplace_back(squared, ref);
  }
  std::sort(absent.begin(), absent.end());
  if (absent.size() > static_cast<std::size_t>(config.clouds_requested))
    absent.resize(static_cast<std::size_t>(config.clouds_requested));
  // Enough is there when the request limit's worth of clouds is: the rest comes in the background.
  if (near.size() < static_cast<std::size_t>(config.clouds_requested))
    for (const auto& [distance, ref] : absent) missing.push_back(ref);
  return near;
}

double MergePipeline::State::self_aliases(SessionId id, CloudSource& clouds) {
  Session& session = sessions[id];
  if (session.self.path_m >= 0 && session.path_m < 1.25 * session.self.path_m) return session.self.aliases;
  const Found* found = finder.find_within({id, session.keyframes});
  std::vector<Case> cases;
  for (const Hypothesis& h : found->hypotheses)
    if (differ(h.T_a_b, Pose::Identity(), h.place_b, elsewhere_m, elsewhere_rad))
      cases.push_back(make_case(id, id, h, clouds));
  std::vector<char> alike(cases.size(), 0);
  const JudgeConfig judge = judge_config();
  for_blocks(cases.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const Hypothesis& h = cases[i].hypothesis;
    const Glance g = glance(cases[i].a, cases[i].b, h.T_a_b, h.place_b, judge);
    alike[i] = fits_alone(g) &&
               differ(g.place.registration.T_target_source, Pose::Identity(), g.place.p_b, elsewhere_m, elsewhere_rad);
  });
  session.self = {session.path_m, static_cast<double>(std::count(alike.begin(), alike.end(), 1))};
  return session.self.aliases;
}

std::vector<Verdict> MergePipeline::State::judge_cases(const std::vector<Case>& cases, double self_aliases,
                                                       AttemptReport& report) const {
  const JudgeConfig config_now = judge_config();
  std::vector<Glance> glances(cases.size());
  {
    const Stopwatch watch(report.times.registration_ms);
    for_blocks(cases.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
      const Case& c = cases[i];
      glances[i] = glance(c.a, c.b, c.hypothesis.T_a_b, c.hypothesis.place_b, config_now);
    });
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < glances.size(); ++i)
    if (glances[i].hopeful) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return promise(glances[i]) > promise(glances[j]); });
  const Stopwatch watch(report.times.verification_ms);
  std::vector<Verdict> verdicts;
  for (const std::size_t i : order) {
    const PlaceCheck& place = glances[i].place;
    const bool known = std::any_of(verdicts.begin(), verdicts.end(), [&](const Verdict& v) {
      return !differ(v.judgement.T_a_b, place.registration.T_target_source, place.p_b, same_placement_m,
                     same_placement_rad);
    });
    if (known || verdicts.size() == judged_closely) continue;
    Verdict verdict{judge(cases[i].a, cases[i].b, glances[i], config_now), place.p_b};
    Evidence& e = verdict.judgement.evidence;
    e.support = cases[i].hypothesis.score;
    e.aliases = self_aliases + static_cast<double>(std::count_if(glances.begin(), glances.end(), [&](const Glance& g) {
                  return fits_alone(g) && differ(g.place.registration.T_target_source, verdict.judgement.T_a_b,
                                                 g.place.p_b, same_placement_m, same_placement_rad);
                }));
    e.probability = probability(verdict.judgement.status, e);
    verdicts.push_back(verdict);
  }
  std::stable_sort(verdicts.begin(), verdicts.end(), [](const Verdict& v, const Verdict& w) {
    return v.judgement.evidence.probability > w.judgement.evidence.probability;
  });
  return verdicts;
}

Alignment* MergePipeline::State::find(SessionId a, SessionId b) {
  for (Alignment& alignment : alignments)
    if (alignment.a == a && alignment.b == b) return &alignment;
  return nullptr;
}

void MergePipeline::State::index_keyframe(SessionId id, const Keyframe& keyframe) {
  const FamilyId& family_id = sessions[id].family;
  auto& index = families[family_id].index;
  const auto& q = keyframe.descriptor.q;
  if (q.empty()) return;
  if (!index) index = make_exact_index(q.size());
  if (index->size() == exact_up_to) {
    index = make_flann_index(q.size());
    for (const auto& [session_id, session] : sessions)
      if (session.family == family_id)
        for (const Keyframe& k : session.keyframes)
          if (!k.descriptor.q.empty()) index->add({session_id, k.sequence}, k.descriptor.q);
  }
  index->add({id, keyframe.sequence}, q);
}

}  // namespace headframe
