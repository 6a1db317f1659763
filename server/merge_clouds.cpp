// Which clouds are asked of the robots, for links are thin: those around the spot where a hypothesis is looked at
// first; while these leave it in doubt, more of the overlap's; and before it is believed those that tell whether the
// mine repeats itself, and where it does what the look farther off needs (merge_farther.cpp).

#include <algorithm>

#include "server/merge_state.hpp"

namespace headframe {
namespace {

const double spot_m = PlaceConfig{}.radius_m;
constexpr std::size_t more = 2;           // times as many as for a first look
constexpr std::size_t cases_awaited = 1;  // that may wait for a first look at a time
constexpr std::size_t cases_asking = 10;  // the most promising: others are looked at with the clouds that are here
constexpr double rival_share = 0.7;       // of the support: weaker rivals of an accepted one ask for no clouds

std::vector<Stand> all_of(const Nearby& n) {
  std::vector<Stand> out;
  std::merge(n.stored.begin(), n.stored.end(), n.obtainable.begin(), n.obtainable.end(), std::back_inserter(out),
             [](const Stand& s, const Stand& t) { return s.keyframe < t.keyframe; });
  return out;
}

bool none_to_come(const Case& c) { return c.a.obtainable.empty() && c.b.obtainable.empty(); }

}  // namespace

Eigen::Vector3d middle_of_overlap(const Case& c) {
  const auto near = near_other(all_of(c.a), all_of(c.b), c.hypothesis.T_a_b, JudgeConfig{}.meet_m);
  return near.empty() ? Eigen::Vector3d::Zero() : near[near.size() / 2].p;
}

Candidates MergePipeline::State::look_for_clouds(const Laid& pair, const std::vector<Hypothesis>& hypotheses,
                                                 const Alignment* known, const CloudSource& clouds,
                                                 AttemptReport& report) {
  Candidates out;
  const bool accepted = known && known->evidence.probability >= config.accept_probability;
  for (const Hypothesis& h : hypotheses) {
    Case made = make_case(pair.a, pair.b, h, clouds);
    const bool weak_rival = accepted && h.score < rival_share * known->evidence.support;
    std::vector<KeyframeRef> wanted;
    const bool may_ask = static_cast<std::size_t>(&h - hypotheses.data()) < cases_asking;
    if (may_ask && worth_clouds(pair) && out.awaited < cases_awaited && !weak_rival)
      wanted = wanted_to_look(pair, made);
    if (wanted.empty()) {
      out.cases.push_back(std::move(made));
      continue;
    }
    ++out.awaited;
    report.wanted.insert(report.wanted.end(), wanted.begin(), wanted.end());
  }
  return out;
}

bool MergePipeline::State::ask_for_more(const Laid& pair, const std::vector<Verdict>& verdicts, std::size_t awaited,
                                        const CloudSource& clouds, AttemptReport& report) {
  if (!worth_clouds(pair)) return false;
  if (!convinces(verdicts.front().judgement.evidence, config)) {
    const auto asks =
        std::find_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.wanted.empty(); });
    if (asks != verdicts.end()) report.wanted.insert(report.wanted.end(), asks->wanted.begin(), asks->wanted.end());
    return false;
  }
  if (awaited > 0) return false;  // it waits for its rivals anyway
  std::vector<KeyframeRef> wanted = verdicts.front().wanted;
  for (const SessionId id : {pair.a, pair.b})
    for (const KeyframeRef& k : sessions.at(id).self.wanted)
      if (clouds.state(k) == CloudState::obtainable) wanted.push_back(k);
  if (wanted.empty()) return false;
  report.wanted.insert(report.wanted.end(), wanted.begin(), wanted.end());
  judged_on.erase(std::minmax(pair.a, pair.b));  // it is judged anew even if they do not come
  return true;
}

Case MergePipeline::State::make_case(SessionId a, SessionId b, const Hypothesis& hypothesis,
                                     const CloudSource& clouds) {
  return {hypothesis, nearby(a, b, hypothesis.T_a_b, clouds), nearby(b, a, hypothesis.T_a_b.inverse(), clouds)};
}

/// Keyframes of `id` that lie within reach of the other session.
Nearby MergePipeline::State::nearby(SessionId id, SessionId other, const Pose& T_id_other,
                                    const CloudSource& clouds) const {
  const double reach_m = JudgeConfig{}.look_m;
  const auto &own = sessions.at(id).keyframes, &theirs = sessions.at(other).keyframes;
  std::vector<Eigen::Vector3d> others;
  others.reserve(theirs.size());
  for (const Keyframe& k : theirs) others.push_back(T_id_other * k.T_local_sensor.translation());
  Nearby out;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const Eigen::Vector3d p = own[i].T_local_sensor.translation();
    const bool reached = std::any_of(others.begin(), others.end(),
                                     [&](const auto& q) { return (p - q).squaredNorm() < reach_m * reach_m; });
    if (!reached || own[i].point_count == 0) continue;
    const CloudState state = clouds.state({id, own[i].sequence});
    if (state == CloudState::stored) out.stored.push_back({i, p});
    if (state == CloudState::obtainable) out.obtainable.push_back({i, p});
  }
  return out;
}

/// The nearest to p first.
void MergePipeline::State::ask(SessionId id, std::vector<Stand> obtainable, const Eigen::Vector3d& p, std::size_t most,
                               std::vector<KeyframeRef>& wanted) const {
  std::stable_sort(obtainable.begin(), obtainable.end(),
                   [&](const Stand& s, const Stand& t) { return (s.p - p).squaredNorm() < (t.p - p).squaredNorm(); });
  if (obtainable.size() > most) obtainable.resize(most);
  for (const Stand& s : obtainable) wanted.push_back({id, sessions.at(id).keyframes[s.keyframe].sequence});
}

std::vector<KeyframeRef> MergePipeline::State::wanted_to_look(const Laid& pair, const Case& c) const {
  std::vector<KeyframeRef> wanted;
  if (none_to_come(c)) return wanted;
  const auto meeting =
      first_meeting(all_of(c.a), all_of(c.b), c.hypothesis.T_a_b, c.hypothesis.place_b, judge_config());
  if (!meeting) return wanted;
  const auto ask_around = [&](SessionId id, const Nearby& stands, std::size_t keyframe) {
    const Eigen::Vector3d p = sessions.at(id).keyframes[keyframe].T_local_sensor.translation();
    const auto here = [&](const Stand& s) { return (s.p - p).norm() < spot_m; };
    const auto enough = static_cast<std::size_t>(config.clouds_requested),
               stored = static_cast<std::size_t>(std::count_if(stands.stored.begin(), stands.stored.end(), here));
    std::vector<Stand> around;
    std::copy_if(stands.obtainable.begin(), stands.obtainable.end(), std::back_inserter(around), here);
    if (stored < enough) ask(id, std::move(around), p, enough - stored, wanted);
  };
  ask_around(pair.a, c.a, meeting->keyframe_a);
  ask_around(pair.b, c.b, meeting->keyframe_b);
  return wanted;
}

std::vector<KeyframeRef> MergePipeline::State::wanted_to_tell(const Laid& pair, const Case& c,
                                                              const Verdict& verdict) const {
  std::vector<KeyframeRef> wanted;
  if (none_to_come(c)) return wanted;
  const JudgeConfig judge = judge_config();
  const Pose& T = verdict.judgement.T_a_b;
  const auto a = all_of(c.a), b = all_of(c.b);
  Judgement whole = verdict.judgement;  // as it would be if all of its overlap were as good
  measure_overlap(whole.evidence, a, b, T, judge);
  weigh(whole);
  if (whole.evidence.probability < config.candidate_probability) return wanted;
  const std::size_t most = more * static_cast<std::size_t>(config.clouds_requested);
  ask(pair.a, near_other(b, c.a.obtainable, T.inverse(), judge.meet_m), T * verdict.p_b, most, wanted);
  ask(pair.b, near_other(a, c.b.obtainable, T, judge.meet_m), verdict.p_b, most, wanted);
  return wanted;
}

}  // namespace headframe
