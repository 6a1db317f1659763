#include "server/merge/session_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "server/place/sanity.hpp"
#include "server/verification/verdict_curves.hpp"
#include "server/verification/verification.hpp"

namespace headframe {
namespace {

/// Hash (FNV-1a) of all that is known of the keyframe except its pose.
std::uint64_t fingerprint_of(const Keyframe& keyframe) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto mix = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211ULL; };
  mix(std::bit_cast<std::uint64_t>(keyframe.stamp_s));
  for (const float f : keyframe.descriptor.q) mix(std::bit_cast<std::uint32_t>(f));
  for (const std::uint8_t code : keyframe.walls.code) mix(code);
  return hash;
}

// Limits of what demands more path; set by hand on live drives of the recordings and of drawn mines (seed 310000).
constexpr double most_similar_places = 4, most_doubt = 2;

/// How far the probability is below beyond_doubt, in log-odds.
double doubt(double probability) {
  const auto log_odds = [](double p) { return std::log(std::max(p, 1e-9) / std::max(1 - p, 1e-9)); };
  return std::max(0.0, log_odds(beyond_doubt) - log_odds(probability));
}

/// Path that the session drove after it was last within reach_m of the other's path; nullopt if it never was.
std::optional<double> path_since(const Session& session, const Session& other, const Pose& T_other_session,
                                 double reach_m) {
  for (std::size_t i = session.keyframes.size(); i-- > 0;) {
    const Eigen::Vector3d p = T_other_session * session.keyframes[i].T_local_sensor.translation();
    if (other.distance_m(p) < reach_m) return session.path_m() - session.path_to_m[i];
  }
  return std::nullopt;
}

}  // namespace

void Session::add(Keyframe keyframe) {
  const Eigen::Vector3d here = keyframe.T_local_sensor.translation();
  if (keyframes.empty()) fingerprint = fingerprint_of(keyframe);
  path_to_m.push_back(keyframes.empty() ? 0 : path_m() + (here - keyframes.back().T_local_sensor.translation()).norm());
  box.extend(here);
  keyframes.push_back(std::move(keyframe));
  set_aside_outliers();
}

void Session::set_aside_outliers() {
  const std::size_t n = keyframes.size(), known = complete ? n : n - std::min<std::size_t>(n, 2);
  for (; asked < known; ++asked) {
    Keyframe& k = keyframes[asked];
    if (fits_neighbours(keyframes, asked)) continue;
    k.walls = {};
    k.point_count = 0;
    k.descriptor = {};
  }
}

double Session::distance_m(const Eigen::Vector3d& p) const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < keyframes.size();) {
    const double away_m = (keyframes[i].T_local_sensor.translation() - p).norm();
    nearest_m = std::min(nearest_m, away_m);
    const double nearer_at_m = path_to_m[i] + away_m - nearest_m;  // before that the path cannot have come nearer
    do ++i;
    while (i < keyframes.size() && path_to_m[i] < nearer_at_m);
  }
  return nearest_m;
}

const Keyframe& SessionMap::add_keyframe(SessionId id, Keyframe keyframe) {
  Session& session = sessions_[id];
  session.complete = session.looked_at = false;
  session.add(frames_.taken_in(id, std::move(keyframe), session.keyframes));
  return session.keyframes.back();
}

void SessionMap::complete(SessionId id) {
  Session& session = sessions_[id];
  session.complete = true;
  session.set_aside_outliers();
}

void SessionMap::set_looked_at(SessionId id, bool looked_at) {
  Session& session = sessions_[id];
  session.looked_at = looked_at && session.complete;
}

void SessionMap::forget(SessionId id) {
  sessions_.erase(id);
  frames_.come_anew(id);
}

OrderedPair SessionMap::ordered(SessionId one, SessionId other) const {
  const auto rank = [&](SessionId id) { return std::tuple(at(id).path_m(), at(id).fingerprint, id); };
  return rank(one) < rank(other) ? OrderedPair{one, other} : OrderedPair{other, one};
}

DescriptorAgreement SessionMap::descriptor_agreement(const OrderedPair& pair) const {
  const Session &a = at(pair.a), &b = at(pair.b);
  if (a.family != b.family || a.family.name != verdict_family) return {{}, {}};
  return {a.keyframes, b.keyframes};
}

// A robot that still drives has not shown what lies ahead of it: an exact copy of a tile looks right until the tile
// ends. So a convincing placement waits until both sessions have shown enough path, and a verdict on a part of a
// session is renewed when the session ends.
double SessionMap::path_awaited_m(const OrderedPair& pair, const Pose& T_a_b, const Evidence& evidence) const {
  const Session &a = at(pair.a), &b = at(pair.b);
  const double reach_m = JudgeConfig{}.meet_m, asked_m = path_asked_m(evidence, config_.shown_m);
  double awaited_m = 0;
  const double of_all_m = std::min({path_asked_m(evidence, short_m), most_of_short_m, config_.shown_m});
  const auto wait_for = [&](const Session& session, const Session& other, const Pose& T_other_session) {
    if (session.complete) {
      awaited_m = std::max(awaited_m, of_all_m - session.path_m());
      return;
    }
    const double since_m = path_since(session, other, T_other_session, reach_m).value_or(0);
    awaited_m = std::max(awaited_m, asked_m - evidence.overlap_m - since_m);
  };
  wait_for(a, b, T_a_b.inverse());
  wait_for(b, a, T_a_b);
  if (evidence.similar_places < config_.look_alikes) return awaited_m;
  return std::max(awaited_m, path_awaited_of_others_m(pair, asked_m));
}

double SessionMap::path_awaited_to_localize_m(SessionId asking, const OrderedPair& pair, const Pose& T_a_b,
                                              const Evidence& evidence) const {
  const bool a_asks = pair.a == asking;
  const Session &session = at(asking), &map = at(a_asks ? pair.b : pair.a);
  const double asked_m = std::max(path_asked_m(evidence, localize_m), looks_like_itself(evidence) * config_.shown_m);
  const Pose T_map_session = a_asks ? T_a_b.inverse() : T_a_b;
  const double since_m = path_since(session, map, T_map_session, JudgeConfig{}.meet_m).value_or(0);
  const double awaited_m = std::max(0.0, asked_m - evidence.overlap_m - since_m);
  if (evidence.similar_places < config_.look_alikes) return awaited_m;
  return std::max(awaited_m, path_awaited_of_others_m(pair, asked_m));
}

double SessionMap::path_asked_m(const Evidence& evidence, double least_m) const {
  return least_m + config_.shown_more_m * std::min(evidence.similar_places, most_similar_places) +
         config_.shown_doubt_m * std::min(doubt(evidence.probability), most_doubt);
}

// Where places look alike, a copy is recognised only when a third session contradicts it (ConsistencyCheck).
double SessionMap::path_awaited_of_others_m(const OrderedPair& pair, double asked_m) const {
  double awaited_m = 0;
  for (const auto& [id, session] : sessions_) {
    if (session.keyframes.empty() || (!at_one_site(id, pair.a) && !at_one_site(id, pair.b))) continue;
    if (session.complete && !session.looked_at) awaited_m = std::max(awaited_m, 1.0);
    if (drives_on(session) && id != pair.a && id != pair.b) awaited_m = std::max(awaited_m, asked_m - session.path_m());
  }
  return awaited_m;
}

bool SessionMap::drives_on(const Session& session) {
  const double count = static_cast<double>(session.keyframes.size()) - of_a_turn;
  return !session.complete && session.awaited && session.path_m() >= least_step_m * count;
}

}  // namespace headframe
