#include "server/registration/verification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/atlas/verdict.hpp"
#include "server/registration/overlap.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

using Stands = std::vector<Stand>;

constexpr double most_tilt_rad = 0.1, most_moved_m = 8;  // of a first registration: else it went astray

struct Nearest {
  const Stand* stand = nullptr;
  double distance_m = std::numeric_limits<double>::max();
};

Nearest nearest_to(std::span<const Stand> stands, const Eigen::Vector3d& p) {
  Nearest out;
  for (const Stand& s : stands)
    if (const double d = (s.p - p).norm(); d < out.distance_m) out = {&s, d};
  return out;
}

/// Adds candidates as far from each other as can be, none nearer than 4 m to another or to the first place, which is
/// taken already.
void spread(const Eigen::Vector3d& first, const Stands& candidates, std::size_t most, Stands& chosen) {
  constexpr double same_place_m = 4;
  while (chosen.size() < most) {
    double farthest = same_place_m;
    const Stand* next = nullptr;
    for (const Stand& s : candidates) {
      double nearest = (s.p - first).norm();
      for (const Stand& other : chosen) nearest = std::min(nearest, (s.p - other.p).norm());
      if (nearest <= farthest) continue;
      farthest = nearest;
      next = &s;
    }
    if (!next) break;
    chosen.push_back(*next);
  }
}

double share(double part, double whole) { return whole > 0 ? part / whole : 0; }

/// They stood near each other with rock between them, round a corner or in the next drift: neither has seen the other's
/// rock. Whatever its registration was caught at is no disagreement. (In tunnel-two 4 % was seen at such places.)
bool nothing_shared(const PlaceCheck& place) {
  constexpr double hardly_any = 0.1;  // of the points of both
  const Visibility known = place.between();
  return known.seen + known.violated < hardly_any * known.all();
}

void gather(Evidence& e, const std::vector<PlaceCheck>& places, const std::vector<bool>& agrees, const Pose& T) {
  Visibility a_by_b, b_by_a, own;
  std::vector<double> residuals;
  double squared = 0, inliers = 0, slide = 0;
  Matched matched;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlaceCheck& p = places[i];
    a_by_b += p.a_by_b;
    b_by_a += p.b_by_a;
    e.worst_place_violation = std::max(e.worst_place_violation, p.between().violation());
    own += p.own;
    if (!agrees[i] && nothing_shared(p)) continue;
    e.places += 1;
    inliers += p.registration.inlier_fraction;
    matched.on += p.matched.on;
    matched.comparable += p.matched.comparable;
    if (!agrees[i]) continue;
    e.places_agreeing += 1;
    residuals.push_back(p.residual_m);
    slide += p.slide_ratio;
    squared += (T * p.p_b - p.p_a).squaredNorm();
    e.rmse_m += p.registration.rmse_m;
  }
  e.inlier_fraction = inliers / e.places;
  e.matched_share = matched.share();
  e.rmse_m /= e.places_agreeing;
  e.slide_ratio = slide / e.places_agreeing;
  e.spread_m = std::sqrt(squared / e.places_agreeing);
  std::sort(residuals.begin(), residuals.end());
  e.residual_m = residuals[residuals.size() / 2];
  Visibility between = a_by_b;
  between += b_by_a;
  e.seen_points = between.seen;
  e.freespace_violation = between.violation();
  e.own_violation = own.violation();
  e.overlap_a = share(a_by_b.seen, a_by_b.all());
  e.overlap_b = share(b_by_a.seen, b_by_a.all());
  e.tilt_deg = tilt_rad(T) * 180 / std::numbers::pi;
}

/// Path, in metres, along which these follow each other in their session. Between keyframes farther apart than any
/// selection puts them the robot drove back over its own path.
double shared_path_m(const Stands& near) {
  constexpr double farthest_m = 15;
  double path = 0;
  for (std::size_t i = 1; i < near.size(); ++i)
    if (const double step_m = (near[i].p - near[i - 1].p).norm();
        near[i].keyframe - near[i - 1].keyframe <= 2 && step_m < farthest_m)
      path += step_m;
  return path;
}

/// The first place's pair stands for itself: it is in `first` already.
std::vector<PlacePair> other_places(const Scene& a, const Scene& b, const Glance& first, const JudgeConfig& config) {
  const Pose& T = first.place.registration.T_target_source;
  Stands chosen;
  for (const double reach_m : {config.close_m, config.meet_m, config.far_m})
    spread(first.place.p_b, near_other(a.stands, b.stands, T, reach_m), config.places - 1, chosen);
  std::vector<std::size_t> of_a, of_b;
  for (const Stand& s : chosen) {
    of_a.push_back(nearest_to(a.stands, T * s.p).stand->keyframe);
    of_b.push_back(s.keyframe);
  }
  const auto places_a = a.places(of_a), places_b = b.places(of_b);
  std::vector<PlacePair> pairs;
  pairs.reserve(chosen.size() + 1);
  pairs.push_back({first.a, first.b});
  for (std::size_t i = 0; i < chosen.size(); ++i) pairs.push_back({places_a[i], places_b[i]});
  return pairs;
}

/// How far T_a_b may be off at p for the drift between there and the first place.
bool within_drift(const PlaceCheck& place, const PlaceCheck& first, const Pose& T, const JudgeConfig& config) {
  const double allowed_m = config.place_drift_m + config.place_drift_share * (place.p_b - first.p_b).norm();
  return usable(place.registration) && (T * place.p_b - place.p_a).norm() < allowed_m &&
         rotation_angle_rad(T.inverse() * place.registration.T_target_source) < config.place_drift_rad;
}

std::vector<bool> agreeing(const std::vector<PlaceCheck>& places, const Pose& T, const JudgeConfig& config) {
  std::vector<bool> out;
  out.reserve(places.size());
  for (const PlaceCheck& p : places) out.push_back(within_drift(p, places[0], T, config));
  return out;
}

}  // namespace

std::vector<Stand> near_other(std::span<const Stand> a, std::span<const Stand> b, const Pose& T_a_b, double reach_m) {
  Stands out;
  for (const Stand& s : b)
    if (nearest_to(a, T_a_b * s.p).distance_m < reach_m) out.push_back(s);
  return out;
}

void measure_overlap(Evidence& e, std::span<const Stand> a, std::span<const Stand> b, const Pose& T_a_b,
                     const JudgeConfig& config) {
  // One may pass where the other stopped: the mean of both.
  Stands of_a, of_b;
  for (const double reach_m : {config.meet_m, config.far_m}) {
    if (!of_a.empty() && !of_b.empty()) break;
    of_a = near_other(b, a, T_a_b.inverse(), reach_m);
    of_b = near_other(a, b, T_a_b, reach_m);
  }
  e.pairs = static_cast<double>(of_a.size() + of_b.size()) / 2;
  e.overlap_m = (shared_path_m(of_a) + shared_path_m(of_b)) / 2;
}

std::optional<Meeting> first_meeting(std::span<const Stand> a, std::span<const Stand> b, const Pose& T_0,
                                     const Eigen::Vector3d& p_b, const JudgeConfig& config) {
  std::optional<Meeting> out;
  double least = std::numeric_limits<double>::max(), nearest_m = config.apart_m;
  for (const Stand& s : b) {
    const Nearest other = nearest_to(a, T_0 * s.p);
    const double cost = (s.p - p_b).norm() + 10 * std::max(0.0, other.distance_m - config.meet_m / 2);
    nearest_m = std::min(nearest_m, other.distance_m);
    if (cost >= least || other.distance_m > config.apart_m) continue;
    least = cost;
    out = {other.stand->keyframe, s.keyframe};
  }
  if (!out || nearest_m <= config.meet_m) return out;
  // Where the paths come nearest to each other there may be rock between them: each looks from where it is nearest to
  // what both saw.
  const Nearest of_a = nearest_to(a, T_0 * p_b), of_b = nearest_to(b, p_b);
  if (std::max(of_a.distance_m, of_b.distance_m) > config.far_m) return out;
  return Meeting{of_a.stand->keyframe, of_b.stand->keyframe};
}

double screen(const Place& a, const Place& b, Pose& T) {
  VgicpConfig coarse;
  coarse.levels = {{2.0F, 400}, {1.0F, 800}};
  coarse.iterations = 8;
  const Registration r = align(a.target, b.source.points, b.source.normals, T, coarse);
  const Pose moved = T.inverse() * r.T_target_source;
  if (!usable(r) || tilt_rad(r.T_target_source) > most_tilt_rad || (moved * b.p - b.p).norm() > most_moved_m) return 0;
  T = r.T_target_source;
  return matched(a, b, T).cautious();
}

Glance glance(const PlacePtr& a, const PlacePtr& b, const Pose& T_0, const JudgeConfig& config) {
  Glance out{false, register_place(*a, *b, T_0, config.place), a, b};
  const Registration& r = out.place.registration;
  const Pose moved = T_0.inverse() * r.T_target_source;
  if (!usable(r) || r.inlier_fraction < config.hopeless_inliers || tilt_rad(r.T_target_source) > most_tilt_rad ||
      (moved * out.place.p_b - out.place.p_b).norm() > most_moved_m)
    return out;
  look_at_place(out.place, *a, *b, r.T_target_source, config.place);
  out.hopeful = out.place.between().violation() < config.hopeless_violation;
  return out;
}

Judgement judge(const Scene& a, const Scene& b, const Glance& first, const JudgeConfig& config) {
  Judgement out;
  out.evidence.freespace_violation = first.place.between().violation();
  out.evidence.inlier_fraction = first.place.registration.inlier_fraction;
  if (!first.hopeful) return out;
  const Pose& T_0 = first.place.registration.T_target_source;
  const std::vector<PlacePair> pairs = other_places(a, b, first, config);
  std::vector<PlaceCheck> places(pairs.size());
  const auto register_all = [&](const Pose& from, std::size_t first_one) {
    for_blocks(pairs.size() - first_one, 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
      places[first_one + i] = register_place(*pairs[first_one + i].a, *pairs[first_one + i].b, from, config.place);
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
  if (slid) {  // each place was caught at a period of its own
    register_all(out.T_a_b, 0);
    agrees = agreeing(places, out.T_a_b, config);
    if (std::find(agrees.begin(), agrees.end(), true) == agrees.end()) return out;
  }
  // Drift is not a contradiction, other rock is.
  for_blocks(places.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const Pose& T = agrees[i] ? places[i].registration.T_target_source : out.T_a_b;
    const bool seen = i == 0 && !slid;
    if (!seen) look_at_place(places[i], *pairs[i].a, *pairs[i].b, T, config.place);
    if (agrees[i]) look_again(places[i], *pairs[i].a, *pairs[i].b, out.T_a_b, config.place);
  });
  gather(out.evidence, places, agrees, out.T_a_b);
  measure_overlap(out.evidence, a.stands, b.stands, out.T_a_b, config);
  out.status = first.place.registration.status;
  if (overlap.weakest_hold < config.held_by_nothing)
    out.status = RegistrationStatus::degenerate;
  else if (overlap.weakest_hold >= VgicpConfig{}.degenerate_below || out.evidence.end_on_match >= ends_meet)
    out.status = RegistrationStatus::converged;
  weigh(out);
  return out;
}

double likeness(const Glance& glance) {
  if (!glance.hopeful) return 0;
  const auto ramp = [](double value, double none, double all) {
    return std::clamp((value - none) / (all - none), 0.0, 1.0);
  };
  return ramp(glance.place.matched.cautious(), 0.65, 0.9) * ramp(glance.place.residual_m, 0.065, 0.04) *
         ramp(glance.place.between().violation(), 0.012, 0.002) *
         ramp(glance.place.registration.direction_hold[0], 0, 0.05);
}

bool fits_alone(const Glance& glance) {
  const Registration& r = glance.place.registration;
  return glance.hopeful && r.status == RegistrationStatus::converged && r.direction_hold[0] > 0.05 &&
         glance.place.matched.cautious() > 0.75 && glance.place.residual_m < 0.045 &&
         glance.place.between().violation() < 0.004;
}

Judgement judge_again(const Scene& a, const Scene& b, const Pose& T_0, const JudgeConfig& config) {
  Stands near;
  for (const double reach_m : {config.meet_m, config.far_m, config.apart_m})
    if (near.empty()) near = near_other(a.stands, b.stands, T_0, reach_m);
  if (near.empty()) return {};
  const auto meeting = first_meeting(a.stands, b.stands, T_0, near[near.size() / 2].p, config);
  if (!meeting) return {};
  const std::size_t at_a = meeting->keyframe_a, at_b = meeting->keyframe_b;
  return judge(a, b, glance(a.places({&at_a, 1}).front(), b.places({&at_b, 1}).front(), T_0, config), config);
}

double best_probability(const Glance& glance, const Evidence& known) {
  Evidence e;
  e.descriptors_compared = known.descriptors_compared;
  e.descriptors_alike = known.descriptors_alike;
  e.worst_place_violation = glance.place.between().violation();
  e.places = e.places_agreeing = e.inlier_fraction = e.weakest_hold = e.end_on_match = 1;
  e.pairs = e.overlap_m = std::numeric_limits<double>::max();
  return probability(RegistrationStatus::converged, e);
}

void weigh(Judgement& judgement) {
  Evidence& e = judgement.evidence;
  e.probability = probability(judgement.status, e);
  Evidence unique = e;
  unique.aliases = unique.repetition = unique.look_alikes = 0;
  e.probability_if_unique = probability(judgement.status, unique);
}

double probability(RegistrationStatus status, const Evidence& e) {
  if (status == RegistrationStatus::too_little_overlap) return 0;
  if (e.tilt_deg > 3) return 0;
  const double z = log_odds(e).sum();
  const double p = 1 / (1 + std::exp(-z));
  // What slides freely along the drift can look right at many places: at most a candidate.
  return status == RegistrationStatus::converged ? p : 0.4 * p;
}

}  // namespace headframe
