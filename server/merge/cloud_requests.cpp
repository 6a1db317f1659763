#include "server/merge/cloud_requests.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

const double spot_m = SubmapConfig{}.radius_m;
const double further_spot_m = spot_m / 2;  // those of the first place say nothing, so they are not enough
constexpr std::size_t more = 2;            // times as many clouds as for the first look
constexpr std::size_t cases_awaited = 1;   // number of cases that may wait for a first look at a time
constexpr std::size_t cases_asking = 10;   // only the best cases request clouds; others use the stored ones
constexpr double settled_m = 3;            // a cloud this near to a place is enough for it; set by hand ...
constexpr double drifted_m = 0.08;         // ... unless the places differ by more than this; set by hand
constexpr double asking_share = 0.7;  // share of the support: weaker rivals of an accepted placement request no clouds

std::vector<KeyframePosition> all_of(const NearbyKeyframes& n) {
  std::vector<KeyframePosition> out;
  std::merge(n.stored.begin(), n.stored.end(), n.obtainable.begin(), n.obtainable.end(), std::back_inserter(out),
             [](const KeyframePosition& s, const KeyframePosition& t) { return s.keyframe < t.keyframe; });
  return out;
}

bool none_to_come(const Case& c) { return c.a.obtainable.empty() && c.b.obtainable.empty(); }

}  // namespace

Eigen::Vector3d middle_of_overlap(const Case& c) {
  const auto near = near_other(all_of(c.a), all_of(c.b), c.hypothesis.T_a_b, JudgeConfig{}.meet_m);
  return near.empty() ? Eigen::Vector3d::Zero() : near[near.size() / 2].p;
}

Candidates CloudRequests::cases_with_clouds(const OrderedPair& pair, const std::vector<Hypothesis>& hypotheses,
                                            const Alignment* known, const Attempt& attempt) const {
  Candidates out;
  const bool accepted = known && known->evidence.probability >= config_.accept_probability;
  for (const Hypothesis& h : hypotheses) {
    Case made = make_case(pair.a, pair.b, h, attempt.clouds);
    const bool weak_rival = accepted && h.score < asking_share * known->evidence.support;
    std::vector<KeyframeRef> wanted;
    const bool may_ask = static_cast<std::size_t>(&h - hypotheses.data()) < cases_asking;
    if (may_ask && out.awaited < cases_awaited && !weak_rival) wanted = clouds_for_screening(pair, made);
    if (wanted.empty()) {
      out.cases.push_back(std::move(made));
      continue;
    }
    ++out.awaited;
    attempt.want(wanted);
  }
  return out;
}

Case CloudRequests::make_case(SessionId a, SessionId b, const Hypothesis& hypothesis, const CloudSource& clouds) const {
  return {hypothesis, nearby(a, b, hypothesis.T_a_b, clouds), nearby(b, a, hypothesis.T_a_b.inverse(), clouds)};
}

/// Keyframes of `id` that lie within reach of the other session.
NearbyKeyframes CloudRequests::nearby(SessionId id, SessionId other, const Pose& T_id_other,
                                      const CloudSource& clouds) const {
  const double reach_m = JudgeConfig{}.look_m;
  const Session &session = sessions_.at(id), &theirs = sessions_.at(other);
  const Pose T_other_id = T_id_other.inverse();
  NearbyKeyframes out;
  double distance_m = 0, from_m = 0, certain_m = -1;  // the last answer holds for so much path
  for (std::size_t i = 0; i < session.keyframes.size(); ++i) {
    const Keyframe& k = session.keyframes[i];
    const Eigen::Vector3d p = k.T_local_sensor.translation();
    if (k.point_count == 0) continue;
    if (session.path_to_m[i] - from_m >= certain_m) {
      distance_m = theirs.distance_m(T_other_id * p);
      from_m = session.path_to_m[i];
      certain_m = std::abs(distance_m - reach_m);
    }
    if (distance_m >= reach_m) continue;
    const CloudState state = clouds.state({id, k.sequence});
    if (state == CloudState::stored) out.stored.push_back({i, p});
    if (state == CloudState::obtainable) out.obtainable.push_back({i, p});
    out.any_let_go |= state == CloudState::let_go;
  }
  return out;
}

/// Requests the clouds nearest to p.
void CloudRequests::ask(SessionId id, std::vector<KeyframePosition> obtainable, const Eigen::Vector3d& p,
                        std::size_t most, std::vector<KeyframeRef>& wanted) const {
  std::stable_sort(obtainable.begin(), obtainable.end(), [&](const KeyframePosition& s, const KeyframePosition& t) {
    return (s.p - p).squaredNorm() < (t.p - p).squaredNorm();
  });
  if (obtainable.size() > most) obtainable.resize(most);
  for (const KeyframePosition& s : obtainable) wanted.push_back({id, sessions_.at(id).keyframes[s.keyframe].sequence});
}

/// Requests the clouds nearest to a keyframe, unless enough within reach_m of it are stored.
void CloudRequests::ask_around(SessionId id, const NearbyKeyframes& nearby, std::size_t keyframe, double reach_m,
                               std::vector<KeyframeRef>& wanted) const {
  const Eigen::Vector3d p = sessions_.at(id).keyframes[keyframe].T_local_sensor.translation();
  const auto here = [&](const KeyframePosition& s) { return (s.p - p).norm() < reach_m; };
  const auto enough = static_cast<std::size_t>(config_.clouds_requested),
             stored = static_cast<std::size_t>(std::count_if(nearby.stored.begin(), nearby.stored.end(), here));
  std::vector<KeyframePosition> around;
  std::copy_if(nearby.obtainable.begin(), nearby.obtainable.end(), std::back_inserter(around), here);
  if (stored < enough) ask(id, std::move(around), p, enough - stored, wanted);
}

std::vector<KeyframeRef> CloudRequests::clouds_for_screening(const OrderedPair& pair, const Case& c) const {
  std::vector<KeyframeRef> wanted;
  if (none_to_come(c)) return wanted;
  const auto meeting = first_meeting(all_of(c.a), all_of(c.b), c.hypothesis.T_a_b, c.hypothesis.place_b, JudgeConfig{});
  if (!meeting) return wanted;
  ask_around(pair.a, c.a, meeting->keyframe_a, spot_m, wanted);
  ask_around(pair.b, c.b, meeting->keyframe_b, spot_m, wanted);
  return wanted;
}

std::vector<KeyframeRef> CloudRequests::clouds_for_further_screening(const OrderedPair& pair, const Case& c) const {
  std::vector<KeyframeRef> wanted;
  if (none_to_come(c)) return wanted;
  const auto a = all_of(c.a), b = all_of(c.b);
  const Pose& T = c.hypothesis.T_a_b;
  const auto meeting = first_meeting(a, b, T, c.hypothesis.place_b, JudgeConfig{});
  if (!meeting) return wanted;
  const Eigen::Vector3d first = sessions_.at(pair.b).keyframes[meeting->keyframe_b].T_local_sensor.translation();
  for (const KeyframePosition& place : further_places(a, b, T, first, JudgeConfig{})) {
    if (!wanted.empty()) break;
    ask_around(pair.a, c.a, nearest_to(a, T * place.p).position->keyframe, further_spot_m, wanted);
    ask_around(pair.b, c.b, place.keyframe, further_spot_m, wanted);
  }
  return wanted;
}

std::vector<KeyframeRef> CloudRequests::clouds_for_contact(const OrderedPair& pair, const Case& c) const {
  std::vector<KeyframeRef> wanted;
  const Pose& T = c.hypothesis.T_a_b;
  const double meet_m = JudgeConfig{}.meet_m;
  const std::size_t most = more * static_cast<std::size_t>(config_.clouds_requested);
  const Eigen::Vector3d& p_b = c.hypothesis.place_b;
  ask(pair.a, near_other(all_of(c.b), c.a.obtainable, T.inverse(), meet_m), T * p_b, most, wanted);
  ask(pair.b, near_other(all_of(c.a), c.b.obtainable, T, meet_m), p_b, most, wanted);
  return wanted;
}

std::vector<KeyframeRef> CloudRequests::clouds_for_verdict(const OrderedPair& pair, const Case& c,
                                                           const Judgement& judged, const Eigen::Vector3d& p_b) const {
  std::vector<KeyframeRef> wanted;
  if (none_to_come(c)) return wanted;
  const JudgeConfig judge;
  const Pose& T = judged.T_a_b;
  const auto a = all_of(c.a), b = all_of(c.b);
  Judgement whole = judged;  // as if all of its overlap were as good, held it along the tunnel and showed ample rock
  if (whole.status == RegistrationStatus::degenerate) whole.status = RegistrationStatus::converged;
  whole.evidence.weakest_hold = 1;
  measure_overlap(whole.evidence, a, b, T, judge);
  constexpr double may_be_believed = 0.5;  // at 0.2, two that share nothing were asked for all their clouds
  if (probability_with_ample_rock(whole) < may_be_believed) return wanted;
  const std::size_t most = more * static_cast<std::size_t>(config_.clouds_requested);
  ask(pair.a, near_other(b, c.a.obtainable, T.inverse(), judge.meet_m), T * p_b, most, wanted);
  ask(pair.b, near_other(a, c.b.obtainable, T, judge.meet_m), p_b, most, wanted);
  if (wanted.empty()) {  // all clouds of the overlap are stored: then those that see it from farther away
    ask(pair.a, c.a.obtainable, T * p_b, most, wanted);
    ask(pair.b, c.b.obtainable, p_b, most, wanted);
  }
  return wanted;
}

std::vector<KeyframeRef> CloudRequests::clouds_to_settle(const OrderedPair& pair, const Case& c,
                                                         double spread_m) const {
  std::vector<KeyframeRef> wanted;
  if (none_to_come(c)) return wanted;
  const Pose& T = c.hypothesis.T_a_b;
  const auto a = all_of(c.a), b = all_of(c.b);
  if (spread_m > drifted_m) {
    const double meet_m = JudgeConfig{}.parted_m;
    for (const auto& s : near_other(b, c.a.obtainable, T.inverse(), meet_m))
      wanted.push_back({pair.a, sessions_.at(pair.a).keyframes[s.keyframe].sequence});
    for (const auto& s : near_other(a, c.b.obtainable, T, meet_m))
      wanted.push_back({pair.b, sessions_.at(pair.b).keyframes[s.keyframe].sequence});
    return wanted;
  }
  const Eigen::Vector3d middle = middle_of_overlap(c);
  std::vector<KeyframePosition> places = other_places(a, b, T, middle, JudgeConfig{});
  places.push_back({0, middle});
  const auto ask_at = [&](SessionId id, const NearbyKeyframes& nearby, const Eigen::Vector3d& p) {
    const auto here = nearest_to(nearby.stored, p), there = nearest_to(nearby.obtainable, p);
    if (here.distance_m <= settled_m || here.distance_m <= there.distance_m || !there.position) return;
    wanted.push_back({id, sessions_.at(id).keyframes[there.position->keyframe].sequence});
  };
  for (const KeyframePosition& place : places) {
    ask_at(pair.a, c.a, T * place.p);
    ask_at(pair.b, c.b, place.p);
  }
  return wanted;
}

}  // namespace headframe
