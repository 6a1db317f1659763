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
  const double share_explained = share(explained, all.seen + all.violated);
  const bool rest_agrees = all.violation() - share_explained < most_unexplained && worst < most_unexplained_at_one;
  if (!rest_agrees || share_explained > most_explained || !plausible(patches)) return {};
  e.freespace_explained = share_explained;
  e.worst_place_explained = e.worst_place_violation - worst;
  std::vector<Change> changes;
  changes.reserve(patches.size());
  for (const ChangePatch& patch : patches) changes.push_back(change_of(patch));
  return changes;
}

void gather(Evidence& e, const std::vector<SubmapCheck>& places, const std::vector<bool>& agrees, const Pose& T) {
  Visibility a_by_b, b_by_a;
  std::vector<double> residuals;
  double squared = 0, inliers = 0;
  Matched matched;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const SubmapCheck& p = places[i];
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
  }
  e.inlier_fraction = inliers / e.places;
  e.matched_share = matched.share();
  e.rmse_m /= e.places_agreeing;
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

/// The submaps of all places: first the pair in `first`, then those of the other places of the overlap.
std::vector<SubmapPair> submap_pairs(const Scene& a, const Scene& b, const ScreeningResult& first,
                                     const JudgeConfig& config) {
  const Pose& T = first.place.registration.T_target_source;
  const std::vector<KeyframePosition> chosen = other_places(a.positions, b.positions, T, first.place.p_b, config);
  std::vector<std::size_t> of_a, of_b;
  for (const KeyframePosition& s : chosen) {
    of_a.push_back(nearest_to(a.positions, T * s.p).position->keyframe);
    of_b.push_back(s.keyframe);
  }
  const auto places_a = a.places(of_a), places_b = b.places(of_b);
  std::vector<SubmapPair> pairs;
  pairs.reserve(chosen.size() + 1);
  pairs.push_back({first.a, first.b});
  for (std::size_t i = 0; i < chosen.size(); ++i) pairs.push_back({places_a[i], places_b[i]});
  return pairs;
}

/// How far T_a_b may be off at the place because of drift between there and the first place.
double drift_allowed_m(const SubmapCheck& place, const SubmapCheck& first, const JudgeConfig& config) {
  return config.place_drift_m + config.place_drift_share * (place.p_b - first.p_b).norm();
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

}  // namespace

Judgement judge(const Scene& a, const Scene& b, const ScreeningResult& first, const JudgeConfig& config) {
  Judgement out;
  out.evidence.freespace_violation = first.place.between().violation();
  out.evidence.inlier_fraction = first.place.registration.inlier_fraction;
  if (!first.hopeful) return out;
  const Pose& T_0 = first.place.registration.T_target_source;
  const std::vector<SubmapPair> pairs = submap_pairs(a, b, first, config);
  std::vector<SubmapCheck> places(pairs.size());
  const auto register_all = [&](const Pose& from, std::size_t first_one) {
    for_blocks(pairs.size() - first_one, 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
      places[first_one + i] = register_submaps(*pairs[first_one + i].a, *pairs[first_one + i].b, from, config.place);
    });
  };
  places[0] = first.place;
  register_all(T_0, 1);
  std::vector<bool> agrees = agreeing(places, T_0, config);
  const Overlap overlap = overlap_of(pairs, places, agrees);
  const Pose T_joined = align_overlap(overlap, combine(places, agrees, T_0), config);
  out.T_a_b = settled(overlap, T_joined, config, out.evidence.end_on_match);
  out.evidence.weakest_hold = overlap.weakest_hold;
  const bool slid = out.T_a_b.matrix() != T_joined.matrix();
  if (slid) {  // each place was registered at a different period
    register_all(out.T_a_b, 0);
    agrees = agreeing(places, out.T_a_b, config);
    if (std::find(agrees.begin(), agrees.end(), true) == agrees.end()) return out;
  }
  // Drift does not contradict a placement; rock of another place does.
  std::vector<std::optional<Pose>> again;
  for (std::size_t i = 0; i < places.size(); ++i)
    again.push_back(agrees[i] ? out.T_a_b : across_within_drift(places[i], places[0], out.T_a_b, config));
  for_blocks(places.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const Pose& T = agrees[i] ? places[i].registration.T_target_source : out.T_a_b;
    const bool seen = i == 0 && !slid;
    if (!seen) check_free_space(places[i], *pairs[i].a, *pairs[i].b, T, config.place);
    if (again[i]) check_free_space_again(places[i], *pairs[i].a, *pairs[i].b, *again[i], config.place);
  });
  gather(out.evidence, places, agrees, out.T_a_b);
  out.changes = gather_changes(out.evidence, places);
  measure_overlap(out.evidence, a.positions, b.positions, out.T_a_b, config);
  out.status = first.place.registration.status;
  if (overlap.weakest_hold < config.held_by_nothing)
    out.status = RegistrationStatus::degenerate;
  else if (overlap.weakest_hold >= VgicpConfig{}.degenerate_below || out.evidence.end_on_match >= ends_meet)
    out.status = RegistrationStatus::converged;
  weigh(out);
  return out;
}

Judgement judge_again(const Scene& a, const Scene& b, const Pose& T_0, const JudgeConfig& config) {
  std::vector<KeyframePosition> near;
  for (const double reach_m : {config.meet_m, config.far_m, config.apart_m})
    if (near.empty()) near = near_other(a.positions, b.positions, T_0, reach_m);
  if (near.empty()) return {};
  const auto meeting = first_meeting(a.positions, b.positions, T_0, near[near.size() / 2].p, config);
  if (!meeting) return {};
  const std::size_t at_a = meeting->keyframe_a, at_b = meeting->keyframe_b;
  return judge(a, b, screen_submaps(a.places({&at_a, 1}).front(), b.places({&at_b, 1}).front(), T_0, config), config);
}

void weigh(Judgement& judgement) {
  Evidence& e = judgement.evidence;
  e.probability = probability(judgement.status, e);
  Evidence unique = e;
  unique.aliases = unique.repetition = unique.look_alikes = unique.mine_look_alikes = 0;
  e.probability_if_unique = probability(judgement.status, unique);
}

}  // namespace headframe
