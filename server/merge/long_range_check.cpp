#include "server/merge/long_range_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/cloud/point_cloud.hpp"
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
/// the spacing of keyframes more, apart_m at most. A wrong placement over 7 m of a cave, which only such a spot
/// contradicts, was believed.
double near_enough_m(const Case& c, const Pose& T_a_b, const JudgeConfig& judge) {
  constexpr double keyframe_spacing_m = 3;
  double least_m = judge.apart_m;
  for (const KeyframePosition& s : c.b.stored) least_m = std::min(least_m, nearest_to(c.a.stored, T_a_b * s.p).second);
  return least_m <= judge.close_m ? judge.close_m : std::min(judge.apart_m, least_m + keyframe_spacing_m);
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

/// Keyframes of both where one is looked at from the other.
struct Spots {
  std::vector<std::pair<std::size_t, std::size_t>> keyframes;  // of a and b
  bool known = false;                                          // all clouds around them are stored
};

/// The spots whose surroundings are known; if there are none, those of which something is stored.
Spots spots_of(const OrderedPair& pair, const Case& c, const Pose& T_a_b, const SessionMap& sessions,
               const CloudSource& clouds, const JudgeConfig& judge, std::set<KeyframeRef>& wanted) {
  Spots known{{}, true}, any;
  const double near_m = near_enough_m(c, T_a_b, judge);
  const Session &a = sessions.at(pair.a), &b = sessions.at(pair.b);
  const auto far_enough = [&](const Spots& from, std::size_t of_b) {
    return from.keyframes.empty() || b.path_to_m[of_b] >= b.path_to_m[from.keyframes.back().second] + step_m;
  };
  for (const KeyframePosition& s : c.b.stored) {
    const auto [other, distance_m] = nearest_to(c.a.stored, T_a_b * s.p);
    if (distance_m > near_m || !far_enough(known, s.keyframe)) continue;
    if (far_enough(any, s.keyframe)) any.keyframes.emplace_back(other->keyframe, s.keyframe);
    const bool known_a = known_around(a, pair.a, other->keyframe, clouds, wanted),
               known_b = known_around(b, pair.b, s.keyframe, clouds, wanted);
    if (known_a && known_b) known.keyframes.emplace_back(other->keyframe, s.keyframe);
  }
  return known.keyframes.empty() ? any : known;
}

void sum_up_contradictions(const std::vector<SubmapCheck>& looked, LongRange& out) {
  std::vector<ChangePatch> changes;
  for (const SubmapCheck& place : looked) changes.insert(changes.end(), place.changes.begin(), place.changes.end());
  const bool may_be = plausible(joined(std::move(changes)));
  for (const SubmapCheck& place : looked) {
    const double violation = place.between().violation();
    out.violation = std::max(out.violation, violation);
    out.unexplained = std::max(out.unexplained, may_be ? place.unexplained() : violation);
  }
}

/// Appends the points of one session's rock that the other saw.
void add_seen(const Points& rock, std::span<const PointSight> seen, Points& out) {
  for (std::size_t i = 0; i < rock.size(); ++i)
    if (seen[i] == PointSight::seen) out.push_back(rock[i]);
}

}  // namespace

void LongRange::tell(Evidence& e) const {
  e.farther_violation = violation;
  e.farther_explained = violation - unexplained;
  e.rock_in_common = rock_in_common;
}

LongRange check_long_range(const OrderedPair& pair, const Case& c, const Judgement& judged,
                           const Eigen::Vector3d& first_b, const SessionMap& sessions, SessionSubmaps& submaps,
                           CloudSource& clouds, const JudgeConfig& judge) {
  constexpr float cube_m = 1;
  LongRange out;
  Spots spots = spots_of(pair, c, judged.T_a_b, sessions, clouds, judge, out.wanted);
  if (judged.evidence.repetition < copies_known) spots.keyframes = spread_evenly(spots.keyframes, spots_unless_copies);
  std::vector<SubmapRequest> asked;
  for (const auto& [of_a, of_b] : spots.keyframes) {
    asked.push_back(submaps.at(pair.a, of_a));
    asked.push_back(submaps.at(pair.b, of_b));
  }
  const std::vector<SubmapPtr> near = submaps.near(asked, clouds), far = submaps.far(asked, clouds);
  std::vector<SubmapCheck> looked(spots.keyframes.size());
  const SubmapConfig seen = judge.with_drift(SessionSubmaps::far_config());
  for_blocks(looked.size(), 1, judge.threads, [&](std::size_t i, std::size_t, std::size_t) {
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
  Points rock_of_a, rock_of_b;
  for (std::size_t i = 0; i < looked.size(); ++i) {
    add_seen(far[2 * i]->rock.points, looked[i].of_a, rock_of_a);
    add_seen(far[2 * i + 1]->rock.points, looked[i].of_b, rock_of_b);
  }
  out.rock_in_common =
      static_cast<double>(voxel_grid(rock_of_a, cube_m).size() + voxel_grid(rock_of_b, cube_m).size()) / 2;
  if (spots.known) sum_up_contradictions(looked, out);
  return out;
}

}  // namespace headframe
