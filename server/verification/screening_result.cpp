#include "server/verification/screening_result.hpp"

#include <algorithm>
#include <limits>

#include "server/verification/overlap.hpp"
#include "server/verification/ramp.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

constexpr double most_tilt_rad = 0.1, most_moved_m = 8;  // of a first registration: else it went astray

/// How well the rock fits, whatever free space says, 0 to 1.
double rock_fits(const ScreeningResult& result) {
  if (!result.hopeful) return 0;
  return ramp(result.place.matched.cautious(), 0.65, 0.9) * ramp(result.place.residual_m, 0.065, 0.04) *
         ramp(result.place.registration.direction_hold[0], 0, 0.05);
}

}  // namespace

double coarse_fit(const Submap& a, const Submap& b, Pose& T) {
  VgicpConfig coarse;
  coarse.levels = {{2.0F, 400}, {1.0F, 800}};
  const Registration r = align(a.target, b.source.points, b.source.normals, T, coarse);
  const Pose moved = T.inverse() * r.T_target_source;
  if (!usable(r) || tilt_rad(r.T_target_source) > most_tilt_rad || (moved * b.p - b.p).norm() > most_moved_m) return 0;
  T = r.T_target_source;
  return matched(a, b, T).cautious();
}

ScreeningResult screen_submaps(const SubmapPtr& a, const SubmapPtr& b, const Pose& T_0, const JudgeConfig& config) {
  ScreeningResult out{false, register_submaps(*a, *b, T_0, config.place), a, b};
  const Registration& r = out.place.registration;
  const Pose moved = T_0.inverse() * r.T_target_source;
  if (!usable(r) || r.inlier_fraction < config.hopeless_inliers || tilt_rad(r.T_target_source) > most_tilt_rad ||
      (moved * out.place.p_b - out.place.p_b).norm() > most_moved_m)
    return out;
  check_free_space(out.place, *a, *b, r.T_target_source, config.place);
  out.hopeful = out.place.unexplained() < config.hopeless_violation;
  return out;
}

double likeness(const ScreeningResult& result) {
  return rock_fits(result) * ramp(result.place.between().violation(), 0.004, 0.001);
}

double resemblance(const ScreeningResult& result) {
  return rock_fits(result) * ramp(result.place.between().violation(), 0.012, 0.0005);
}

bool fits_alone(const ScreeningResult& result) {
  const Registration& r = result.place.registration;
  return result.hopeful && r.status == RegistrationStatus::converged && r.direction_hold[0] > 0.05 &&
         result.place.matched.cautious() > 0.75 && result.place.residual_m < 0.045 &&
         result.place.between().violation() < 0.002;
}

Evidence ideal_evidence() {
  Evidence e;
  e.places = e.places_agreeing = e.inlier_fraction = e.matched_share = e.weakest_hold = e.end_on_match = 1;
  e.descriptors_alike = e.own_scatter_m = 1;
  e.descriptors_compared = e.pairs = e.overlap_m = std::numeric_limits<double>::max();
  e.mine_similar_places = 0;
  e.rock_in_common = e.support = std::numeric_limits<double>::infinity();
  return e;
}

double best_probability(const ScreeningResult& result, Evidence best) {
  best.worst_place_violation = result.place.between().violation();
  best.worst_place_explained = best.worst_place_violation - result.place.unexplained();
  return probability(RegistrationStatus::converged, best);
}

}  // namespace headframe
