#include "server/merge/long_range_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/session/same_placement.hpp"
#include "server/support/parallel.hpp"

namespace headframe {
namespace {

constexpr double step_m = 4;                    // of b's path
constexpr std::size_t spots_unless_copies = 4;  // the ends of the overlap, and between

/// The keyframe of a's nearest to p, and how far it is.
std::pair<const KeyframePosition*, double> nearest_to(const std::vector<KeyframePosition>& a,
                                                      const Eigen::Vector3d& p) {
  std::pair<const KeyframePosition*, double> out{nullptr, std::numeric_limits<double>::infinity()};
  for (const KeyframePosition& s : a)
    if (const double distance_m = (s.p - p).norm(); distance_m < out.second) out = {&s, distance_m};
  return out;
}

/// How near the paths have to pass each other at a spot: close_m; or, if they never do, as near as they come and about
/// the spacing of keyframes more, far_m at most. A wrong placement over 7 m of a cave, which only such a spot
/// contradicts, was believed.
double near_enough_m(const Case& c, const Pose& T_a_b, const JudgeConfig& judge) {
  constexpr double keyframe_spacing_m = 3;
  double least_m = judge.far_m;
  for (const KeyframePosition& s : c.b.stored) least_m = std::min(least_m, nearest_to(c.a.stored, T_a_b * s.p).second);
  return least_m <= judge.close_m ? judge.close_m : std::min(judge.far_m, least_m + keyframe_spacing_m);
}

/// Whether all clouds of the path within look_m of a keyframe are stored. Adds those that are obtainable to `wanted`.
bool known_around(const Session& session, SessionId id, std::size_t keyframe, const CloudSource& clouds,
                  std::set<KeyframeRef>& wanted) {
  const double reach_m = SessionSubmaps::far_config().look_m, here_m = session.path_to_m[keyframe];
  bool known = true;
  for (std::size_t i = 0; i < session.keyframes.size(); ++i) {
    const Keyframe& k = session.keyframes[i];
    if (k.point_count == 0 || std::abs(session.path_to_m[i] - here_m) >= reach_m) continue;
    const CloudState state = clouds.state({id, k.sequence});
    known &= state == CloudState::stored;
    if (state == CloudState::obtainable) wanted.insert({id, k.sequence});
  }
  return known;
}

/// At most `most` of them, evenly spread, including both ends.
template <class T>
std::vector<T> spread_evenly(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(all[i * (all.size() - 1) / (most - 1)]);
  return out;
}

}  // namespace

LongRange check_long_range(const OrderedPair& pair, const Case& c, const Judgement& judged,
                           const Eigen::Vector3d& first_b, const SessionMap& sessions, SessionSubmaps& submaps,
                           CloudSource& clouds, const JudgeConfig& judge) {
  LongRange out;
  std::vector<std::pair<std::size_t, std::size_t>> spots;  // keyframes of a and b
  double next_m = std::numeric_limits<double>::lowest();
  const double near_m = near_enough_m(c, judged.T_a_b, judge);
  for (const KeyframePosition& s : c.b.stored) {
    const double path_m = sessions.at(pair.b).path_to_m[s.keyframe];
    const auto [other, distance_m] = nearest_to(c.a.stored, judged.T_a_b * s.p);
    if (distance_m > near_m || path_m < next_m) continue;
    const bool known_a = known_around(sessions.at(pair.a), pair.a, other->keyframe, clouds, out.wanted),
               known_b = known_around(sessions.at(pair.b), pair.b, s.keyframe, clouds, out.wanted);
    if (!known_a || !known_b) continue;
    next_m = path_m + step_m;
    spots.emplace_back(other->keyframe, s.keyframe);
  }
  if (judged.evidence.repetition < copies_known) spots = spread_evenly(spots, spots_unless_copies);
  std::vector<SubmapRequest> asked;
  for (const auto& [of_a, of_b] : spots) {
    asked.push_back(submaps.at(pair.a, of_a));
    asked.push_back(submaps.at(pair.b, of_b));
  }
  const std::vector<SubmapPtr> near = submaps.near(asked, clouds), far = submaps.far(asked, clouds);
  std::vector<SubmapCheck> looked(spots.size());
  const SubmapConfig seen = judge.with_drift(SessionSubmaps::far_config());
  for_blocks(spots.size(), 1, judge.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const Submap &of_a = *near[2 * i], &of_b = *near[2 * i + 1];
    SubmapCheck place = register_submaps(of_a, of_b, judged.T_a_b, judge.place);
    const Pose& T = place.registration.T_target_source;
    const PlacementTolerance drift{judge.drift_allowed_m((of_b.p - first_b).norm()), judge.place_drift_rad};
    const bool drifted = place.registration.status != RegistrationStatus::too_little_overlap &&
                         same_placement(T, judged.T_a_b, of_b.p, drift);
    check_free_space(place, *far[2 * i], *far[2 * i + 1], drifted ? T : judged.T_a_b, seen);
    if (drifted) check_free_space_again(place, *far[2 * i], *far[2 * i + 1], judged.T_a_b, seen);
    looked[i] = std::move(place);
  });
  std::vector<ChangePatch> changes;
  for (const SubmapCheck& place : looked) changes.insert(changes.end(), place.changes.begin(), place.changes.end());
  const bool may_be = plausible(joined(std::move(changes)));
  for (const SubmapCheck& place : looked) {
    const double violation = place.between().violation();
    out.violation = std::max(out.violation, violation);
    out.unexplained = std::max(out.unexplained, may_be ? place.unexplained() : violation);
  }
  return out;
}

}  // namespace headframe
