#include "tests/bench/live/live_watch.hpp"

#include <algorithm>
#include <cstdio>

namespace headframe::bench {
namespace {

Pose T_world_local(const DrivenSession& session) {
  return session.path.T_world_sensor.front() * session.path.T_local_sensor.front().inverse();
}

NamedPair named(const LiveRun& run, SessionId a, SessionId b) {
  NamedPair pair{run.sessions().at(a).driven->name, run.sessions().at(b).driven->name};
  if (pair.second < pair.first) std::swap(pair.first, pair.second);
  return pair;
}

using Pairs = std::map<std::pair<SessionId, SessionId>, Pose>;  // a < b

Pairs together(const Atlas& atlas) {
  Pairs out;
  for (const Component& component : atlas.components)
    for (const Placement& a : component.placements)
      for (const Placement& b : component.placements)
        if (a.session < b.session)
          out[{a.session, b.session}] = a.T_component_session.inverse() * b.T_component_session;
  return out;
}

const Alignment* alignment_of(const LiveRun& run, SessionId a, SessionId b) {
  for (const Alignment& k : run.pipeline().alignments())
    if (k.a == a && k.b == b) return &k;
  return nullptr;
}

/// Path of one session since so much was known of it.
double farther_m(const LiveRun& run, SessionId a, SessionId b, const Stood& stood) {
  return std::max(run.sessions().at(a).path_m - stood.known_a_m, run.sessions().at(b).path_m - stood.known_b_m);
}

}  // namespace

bool truly_meet(const DrivenSession& a, const DrivenSession& b) {
  return a.world == b.world && overlap_error(a.path, b.path, Pose::Identity()).pairs > 0;
}

Standing standing_of(const DrivenSession& a, const DrivenSession& b, const Pose& T_a_b) {
  if (a.world != b.world) return {true, -1};
  const Pose T_true = T_world_local(a).inverse() * T_world_local(b);
  const test::OverlapError error = overlap_error(a.path, b.path, T_a_b);
  if (error.pairs == 0) {
    const double off_m = (T_true.inverse() * T_a_b).translation().norm();
    return {off_m > 10, off_m};
  }
  const double drift_m = overlap_error(a.path, b.path, T_true).translation_m;
  return {error.translation_m > std::max(1.0, 0.5 + 2 * drift_m) || error.rotation_deg > 5, error.translation_m};
}

void LiveWatch::close(Now& now, const LiveRun& run, bool at_end) {
  now.stood.to_s = run.now_s();
  now.stood.at_end = at_end;
  (now.wrong ? wrong_ : right_).push_back(now.stood);
}

void LiveWatch::note_claims(const LiveRun& run) {
  for (const Component& component : run.pipeline().atlas().components)
    for (const ProvisionalPlacement& p : component.provisional)
      wrong_provisional_ |= standing_of(*run.sessions().at(component.id).driven, *run.sessions().at(p.session).driven,
                                        p.T_component_session)
                                .wrong;
  for (const Alignment& k : run.pipeline().alignments()) {
    const bool waits = k.state == AlignmentState::provisional ||
                       (k.state == AlignmentState::candidate && k.evidence.awaited_m > 0 && convinces(k.evidence, {}));
    if (!waits && k.state != AlignmentState::published) {
      claimed_.erase(k.id);
      continue;
    }
    const LiveSession &a = run.sessions().at(k.a), &b = run.sessions().at(k.b);
    const auto known = claimed_.find(k.id);
    if (known != claimed_.end() && known->second.state == k.state &&
        known->second.evidence.awaited_m == k.evidence.awaited_m)
      continue;
    claims_.push_back({named(run, k.a, k.b), k.state, run.now_s(), standing_of(*a.driven, *b.driven, k.T_a_b),
                       k.evidence, a.path_m, b.path_m});
    claimed_[k.id] = claims_.back();
  }
}

std::vector<double> LiveWatch::later_m() const {
  std::vector<double> out;
  for (const Stood& told : right_) {
    if (!told.at_end) continue;
    const auto first = std::find_if(claims_.begin(), claims_.end(),
                                    [&](const Claim& c) { return c.pair == told.pair && !c.standing.wrong; });
    if (first == claims_.end() || first->at_s > told.from_s) continue;  // merged by way of others
    out.push_back(std::max({0.0, told.known_a_m - first->known_a_m, told.known_b_m - first->known_b_m}));
  }
  return out;
}

void LiveWatch::look(const LiveRun& run) {
  note_claims(run);
  const Pairs now = together(run.pipeline().atlas());
  for (auto known = standing_.begin(); known != standing_.end();) {
    if (!now.contains(known->first)) {
      close(known->second, run, false);
      known = standing_.erase(known);
    } else {
      ++known;
    }
  }
  for (const auto& [pair, T_a_b] : now) {
    const LiveSession &a = run.sessions().at(pair.first), &b = run.sessions().at(pair.second);
    const Standing standing = standing_of(*a.driven, *b.driven, T_a_b);
    auto known = standing_.find(pair);
    if (known != standing_.end() && known->second.wrong != standing.wrong) {
      close(known->second, run, false);
      standing_.erase(known);
      known = standing_.end();
    }
    if (known == standing_.end()) {
      Stood stood{named(run, pair.first, pair.second), run.now_s(), run.now_s()};
      stood.off_m = standing.off_m;
      stood.known_a_m = a.path_m;
      stood.known_b_m = b.path_m;
      if (const Alignment* k = alignment_of(run, pair.first, pair.second)) stood.evidence = k->evidence;
      known = standing_.emplace(pair, Now{standing.wrong, stood}).first;
    }
    known->second.stood.path_m = farther_m(run, pair.first, pair.second, known->second.stood);
  }
}

void LiveWatch::finish(const LiveRun& run) {
  look(run);
  for (auto& [pair, now] : standing_) {
    now.stood.path_m = farther_m(run, pair.first, pair.second, now.stood);
    close(now, run, true);
  }
  standing_.clear();
}

std::size_t LiveWatch::right_withdrawn() const {
  return static_cast<std::size_t>(
      std::count_if(right_.begin(), right_.end(), [](const Stood& stood) { return !stood.at_end; }));
}

namespace {

Eigen::Vector3d nearest_of_b(const DrivenSession& a, const DrivenSession& b, const Pose& T_a_b) {
  Eigen::Vector3d nearest = Eigen::Vector3d::Zero();
  double least_m = std::numeric_limits<double>::max();
  for (const Keyframe& kb : b.keyframes)
    for (const Keyframe& ka : a.keyframes) {
      const Eigen::Vector3d p_b = kb.T_local_sensor.translation();
      const double m = (ka.T_local_sensor.translation() - T_a_b * p_b).norm();
      if (m < least_m) least_m = m, nearest = p_b;
    }
  return nearest;
}

}  // namespace

std::map<NamedPair, EndState> LiveWatch::end_of(const LiveRun& run) {
  std::map<NamedPair, EndState> out;
  const Pairs merged = together(run.pipeline().atlas());
  for (const auto& [id_a, a] : run.sessions())
    for (const auto& [id_b, b] : run.sessions()) {
      if (id_a >= id_b) continue;
      EndState end;
      if (const Alignment* k = alignment_of(run, id_a, id_b)) end.state = k->state;
      if (const auto found = merged.find({id_a, id_b}); found != merged.end()) {
        end.together = true;
        const bool in_order = a.driven->name < b.driven->name;
        end.T_a_b = in_order ? found->second : found->second.inverse();
        end.p_b =
            in_order ? nearest_of_b(*a.driven, *b.driven, end.T_a_b) : nearest_of_b(*b.driven, *a.driven, end.T_a_b);
      }
      out[named(run, id_a, id_b)] = end;
    }
  return out;
}

namespace {

bool same_end(const EndState& one, const EndState& other) {
  const bool published = one.state == AlignmentState::published;
  return one.together == other.together && published == (other.state == AlignmentState::published) &&
         (!published || ((one.T_a_b * one.p_b - other.T_a_b * one.p_b).norm() < 0.05 &&
                         rotation_angle_rad(one.T_a_b.inverse() * other.T_a_b) < 0.005));
}

}  // namespace

std::vector<std::string> differences(const std::map<NamedPair, EndState>& one,
                                     const std::map<NamedPair, EndState>& other) {
  std::vector<std::string> out;
  for (const auto& [pair, end] : one) {
    const EndState& theirs = other.at(pair);
    if (same_end(end, theirs)) continue;
    char text[200];
    std::snprintf(text, sizeof text, "%s and %s: %s%s, else %s%s, %.2f m", pair.first.c_str(), pair.second.c_str(),
                  std::string(to_string(end.state)).c_str(), end.together ? " together" : "",
                  std::string(to_string(theirs.state)).c_str(), theirs.together ? " together" : "",
                  (end.T_a_b * end.p_b - theirs.T_a_b * end.p_b).norm());
    out.emplace_back(text);
  }
  return out;
}

}  // namespace headframe::bench
