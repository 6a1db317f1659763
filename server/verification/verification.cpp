#include "server/verification/verification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "server/support/parallel.hpp"
#include "server/verification/overlap.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

// Shares of the points where two sessions meet: what changes may explain at most, and what may remain unexplained.
constexpr double most_explained = 0.03, most_unexplained = 0.002, most_unexplained_at_one = 0.006;

double share(double part, double whole) { return whole > 0 ? part / whole : 0; }

/// Whether the two keyframes stood near each other with rock between them, around a corner or in the next tunnel, so
/// that neither saw the other's rock. The registration of such a place is meaningless and not counted as a
/// disagreement. (In tunnel-two 4 % of the points were seen at such places.)
bool nothing_shared(const SubmapCheck& place) {
  constexpr double hardly_any = 0.1;  // of the points of both
  const Visibility known = place.between();
  return known.seen + known.violated < hardly_any * known.all();
}

/// Sets what changes of the mine explain, if they are credible: all places have to agree, the walls have to hold the
/// placement, and the rest of the overlap has to agree too. (Without this, a placement in tunnels of equal pieces that
/// was 5.6 m off along the tunnel, with one of six places disagreeing, was accepted.)
std::vector<Change> gather_changes(Evidence& e, const std::vector<SubmapCheck>& places) {
  if (e.places_agreeing < e.places || e.weakest_hold < held_well) return {};
  std::vector<ChangePatch> patches;
  Visibility all;
  double explained = 0, worst = 0;
  for (const SubmapCheck& place : places) {
    patches.insert(patches.end(), place.changes.begin(), place.changes.end());
    all += place.between();
    for (const ChangePatch& change : place.changes) explained += static_cast<double>(change.points.size());
    worst = std::max(worst, place.unexplained());
  }
  patches = joined(std::move(patches));
  const double share_explained = explained / all.compared();
  const bool rest_agrees = all.violation() - share_explained < most_unexplained && worst < most_unexplained_at_one;
  if (!rest_agrees || share_explained > most_explained || !plausible(patches)) return {};
  e.freespace_explained = share_explained;
  e.worst_place_explained = e.worst_place_violation - worst;
  std::vector<Change> changes;
  changes.reserve(patches.size());
  for (const ChangePatch& patch : patches) changes.push_back(change_of(patch));
  return changes;
}

/// The submaps of both sessions at the places at which a placement is judged, and what was found there.
struct Places {
  std::vector<SubmapPair> pairs;
  std::vector<SubmapCheck> checks;
};

void gather(Evidence& e, const Places& places, const std::vector<bool>& agrees, const Pose& T) {
  Visibility a_by_b, b_by_a;
  std::vector<double> residuals;
  double squared = 0, inliers = 0;
  Matched matched;
  for (std::size_t i = 0; i < places.checks.size(); ++i) {
    const SubmapCheck& p = places.checks[i];
    a_by_b += p.a_by_b;
    b_by_a += p.b_by_a;
    e.worst_place_violation = std::max(e.worst_place_violation, p.between().violation());
    if (!agrees[i] && nothing_shared(p)) continue;
    e.places += 1;
    inliers += p.registration.inlier_fraction;
    matched.on += p.matched.on;
    matched.comparable += p.matched.comparable;
    if (!agrees[i]) continue;
    e.places_agreeing += 1;
    residuals.push_back(p.residual_m);
    squared += (T * p.p_b - p.p_a).squaredNorm();
    e.rmse_m += p.registration.rmse_m;
    e.own_scatter_m += std::hypot(places.pairs[i].a->scatter_m, places.pairs[i].b->scatter_m) / std::numbers::sqrt2;
  }
  e.inlier_fraction = inliers / e.places;
  e.matched_share = matched.share();
  e.rmse_m /= e.places_agreeing;
  e.own_scatter_m /= e.places_agreeing;
  e.spread_m = std::sqrt(squared / e.places_agreeing);
  std::sort(residuals.begin(), residuals.end());
  e.residual_m = residuals[residuals.size() / 2];
  Visibility between = a_by_b;
  between += b_by_a;
  e.seen_points = between.seen;
  e.freespace_violation = between.violation();
  e.overlap_a = share(a_by_b.seen, a_by_b.all());
  e.overlap_b = share(b_by_a.seen, b_by_a.all());
  e.tilt_deg = tilt_rad(T) * 180 / std::numbers::pi;
}

/// Registers the places from number `first` on, each by itself.
void register_each(Places& places, std::size_t first, const Pose& T_a_b, const JudgeConfig& config) {
  for_blocks(places.pairs.size() - first, 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const SubmapPair& pair = places.pairs[first + i];
    places.checks[first + i] = register_submaps(*pair.a, *pair.b, T_a_b, config.place);
  });
}

/// These keyframes of b, each with the nearest one of a.
std::vector<Meeting> meetings_of(const Scene& scene, std::span<const KeyframePosition> of_b, const Pose& T_a_b) {
  std::vector<Meeting> meetings;
  for (const KeyframePosition& s : of_b)
    meetings.push_back({nearest_to(scene.a, T_a_b * s.p).position->keyframe, s.keyframe});
  return meetings;
}

/// Where the overlap has its middle; nullopt if the two do not come near each other.
std::optional<Meeting> middle_meeting(const Scene& scene, const Pose& T_a_b, const JudgeConfig& config) {
  std::vector<KeyframePosition> near;
  for (const double reach_m : {config.meet_m, config.far_m, config.apart_m})
    if (near.empty()) near = near_other(scene.a, scene.b, T_a_b, reach_m);
  if (near.empty()) return std::nullopt;
  return first_meeting(scene.a, scene.b, T_a_b, near[near.size() / 2].p, config);
}

/// Adds the places of b where T_a_b puts them on a, and registers them.
void add_places(const Scene& scene, std::span<const KeyframePosition> of_b, const Pose& T_a_b,
                const JudgeConfig& config, Places& places) {
  const std::size_t before = places.pairs.size();
  for (SubmapPair& pair : scene.places(meetings_of(scene, of_b, T_a_b))) places.pairs.push_back(std::move(pair));
  places.checks.resize(places.pairs.size());
  register_each(places, before, T_a_b, config);
}

/// Whether the last place contradicts its own registration, for which its free space is checked, and T_a_b too.
bool last_refutes(Places& places, const Pose& T_a_b, const JudgeConfig& config) {
  SubmapCheck& last = places.checks.back();
  if (!usable(last.registration)) return false;
  const auto& [a, b] = places.pairs.back();
  const SubmapConfig drifting = config.with_drift(config.place);
  check_free_space(last, *a, *b, last.registration.T_target_source, drifting);
  SubmapCheck least = last;
  if (least.unexplained() >= config.refuting_violation) check_free_space_again(least, *a, *b, T_a_b, drifting);
  return least.unexplained() >= config.refuting_violation;
}

/// How far T_a_b may be off at the place because of drift between there and the first place.
double drift_allowed_m(const SubmapCheck& place, const SubmapCheck& first, const JudgeConfig& config) {
  return config.drift_allowed_m((place.p_b - first.p_b).norm());
}

bool within_drift(const SubmapCheck& place, const SubmapCheck& first, const Pose& T, const JudgeConfig& config) {
  return usable(place.registration) && (T * place.p_b - place.p_a).norm() < drift_allowed_m(place, first, config) &&
         rotation_angle_rad(T.inverse() * place.registration.T_target_source) < config.place_drift_rad;
}

/// For a place that slid along a tunnel when it was registered alone: T_a_b moved across the tunnel to where that
/// registration lies. Nullopt if drift does not explain so much.
std::optional<Pose> across_within_drift(const SubmapCheck& place, const SubmapCheck& first, const Pose& T_a_b,
                                        const JudgeConfig& config) {
  if (!usable(place.registration)) return std::nullopt;
  const Pose moved = moved_across(place, T_a_b);
  const double moved_m = (moved.translation() - T_a_b.translation()).norm();
  return moved_m < drift_allowed_m(place, first, config) ? std::optional(moved) : std::nullopt;
}

std::vector<bool> agreeing(const std::vector<SubmapCheck>& places, const Pose& T, const JudgeConfig& config) {
  std::vector<bool> out;
  out.reserve(places.size());
  for (const SubmapCheck& p : places) out.push_back(within_drift(p, places[0], T, config));
  return out;
}

/// Finds one transform for all places, how firmly the walls hold it, and its status. Returns which places agree; if
/// none does, the status stays too_little_overlap.
std::vector<bool> place_by_all(Places& places, const JudgeConfig& config, Judgement& out) {
  const Pose T_0 = places.checks[0].registration.T_target_source;
  const RegistrationStatus first = places.checks[0].registration.status;
  std::vector<bool> agrees = agreeing(places.checks, T_0, config);
  const Overlap overlap = overlap_of(places.pairs, places.checks, agrees);
  const Pose T_joined = align_overlap(overlap, combine(places.checks, agrees, T_0), config);
  out.T_a_b = settled(overlap, T_joined, config, out.evidence.end_on_match);
  out.evidence.weakest_hold = overlap.weakest_hold;
  if (out.T_a_b.matrix() != T_joined.matrix()) {  // each place was registered at a different period
    register_each(places, 0, out.T_a_b, config);
    agrees = agreeing(places.checks, out.T_a_b, config);
    if (std::find(agrees.begin(), agrees.end(), true) == agrees.end()) return agrees;
  }
  out.status = first;
  if (overlap.weakest_hold < config.held_by_nothing)
    out.status = RegistrationStatus::degenerate;
  else if (overlap.weakest_hold >= VgicpConfig{}.degenerate_below || out.evidence.end_on_match >= ends_meet)
    out.status = RegistrationStatus::converged;
  return agrees;
}

/// Checks the free space of all places. Drift does not contradict a placement, neither between the places nor between a
/// place and what is seen from it; rock of another place does.
void check_places(Places& places, const std::vector<bool>& agrees, const Pose& T_a_b, const JudgeConfig& config) {
  const SubmapConfig drifting = config.with_drift(config.place);
  std::vector<std::optional<Pose>> again;
  for (std::size_t i = 0; i < agrees.size(); ++i)
    again.push_back(agrees[i] ? T_a_b : across_within_drift(places.checks[i], places.checks[0], T_a_b, config));
  for_blocks(agrees.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    SubmapCheck& place = places.checks[i];
    const auto& [a, b] = places.pairs[i];
    const bool clear = agrees[i] && place.between().all() > 0 && place.between().violated == 0;  // by screening
    if (!clear) check_free_space(place, *a, *b, agrees[i] ? place.registration.T_target_source : T_a_b, drifting);
    if (again[i]) check_free_space_again(place, *a, *b, *again[i], drifting);
  });
}

}  // namespace

Judgement judge(const Scene& scene, const ScreeningResult& first, const JudgeConfig& config) {
  Judgement out;
  out.evidence.freespace_violation = first.place.between().violation();
  out.evidence.inlier_fraction = first.place.registration.inlier_fraction;
  if (!first.hopeful) return out;
  const Pose& T_0 = first.place.registration.T_target_source;
  const auto others = other_places(scene.a, scene.b, T_0, first.place.p_b, config);
  const bool doubted = first.place.unexplained() >= config.doubted_violation && !others.empty();
  const auto farthest = std::span(others).first(doubted ? 1 : 0);
  Places places{{{first.a, first.b}}, {first.place}};
  std::vector<bool> agrees;
  add_places(scene, farthest, T_0, config, places);
  if (doubted && last_refutes(places, T_0, config)) {
    out.T_a_b = T_0;
    out.status = first.place.registration.status;
    agrees = agreeing(places.checks, T_0, config);
    out.evidence.weakest_hold = overlap_of(places.pairs, places.checks, agrees).weakest_hold;
  } else {
    add_places(scene, std::span(others).subspan(farthest.size()), T_0, config, places);
    agrees = place_by_all(places, config, out);
    if (out.status == RegistrationStatus::too_little_overlap) return out;
    check_places(places, agrees, out.T_a_b, config);
  }
  gather(out.evidence, places, agrees, out.T_a_b);
  out.changes = gather_changes(out.evidence, places.checks);
  measure_overlap(out.evidence, scene.a, scene.b, out.T_a_b, config);
  weigh(out);
  return out;
}

Judgement judge_again(const Scene& scene, const Pose& T_0, const JudgeConfig& config) {
  const auto meeting = middle_meeting(scene, T_0, config);
  if (!meeting) return {};
  const SubmapPair at = scene.places({&*meeting, 1}).front();
  return judge(scene, screen_submaps(at.a, at.b, T_0, config), config);
}

double violation_at(const Scene& scene, const Pose& T_a_b, const JudgeConfig& config) {
  const auto meeting = middle_meeting(scene, T_a_b, config);
  if (!meeting) return 0;
  std::vector<SubmapPair> places = scene.places({&*meeting, 1});
  const auto others = other_places(scene.a, scene.b, T_a_b, places.front().b->p, config);
  for (SubmapPair& place : scene.places(meetings_of(scene, others, T_a_b))) places.push_back(std::move(place));
  std::vector<double> violations(places.size());
  for_blocks(places.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    SubmapCheck place;
    check_free_space(place, *places[i].a, *places[i].b, T_a_b, config.place);
    violations[i] = place.between().violation();
  });
  return *std::max_element(violations.begin(), violations.end());
}

void weigh(Judgement& judgement) {
  Evidence& e = judgement.evidence;
  e.probability = probability(judgement.status, e);
  Evidence unique = e;
  unique.aliases = unique.repetition = unique.look_alikes = unique.mine_look_alikes = unique.similar_places =
      unique.mine_similar_places = 0;
  e.probability_if_unique = probability(judgement.status, unique);
}

double probability_with_ample_rock(const Judgement& judgement) {
  Evidence e = judgement.evidence;
  e.rock_in_common = ideal_evidence().rock_in_common;
  return probability(judgement.status, e);
}

}  // namespace headframe
