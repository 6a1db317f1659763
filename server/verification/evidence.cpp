#include "server/verification/evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/verification/ramp.hpp"

namespace headframe {
namespace {

constexpr std::array<EvidenceField, 37> fields{{
    {"probability", &Evidence::probability},
    {"pairs", &Evidence::pairs},
    {"places", &Evidence::places},
    {"places_agreeing", &Evidence::places_agreeing},
    {"inlier_fraction", &Evidence::inlier_fraction},
    {"matched_share", &Evidence::matched_share},
    {"rmse_m", &Evidence::rmse_m},
    {"own_scatter_m", &Evidence::own_scatter_m},
    {"residual_m", &Evidence::residual_m},
    {"spread_m", &Evidence::spread_m},
    {"overlap_m", &Evidence::overlap_m},
    {"path_m", &Evidence::path_m},
    {"awaited_m", &Evidence::awaited_m},
    {"aliases", &Evidence::aliases},
    {"repetition", &Evidence::repetition},
    {"look_alikes", &Evidence::look_alikes},
    {"mine_look_alikes", &Evidence::mine_look_alikes},
    {"similar_places", &Evidence::similar_places},
    {"mine_similar_places", &Evidence::mine_similar_places},
    {"overlap_a", &Evidence::overlap_a},
    {"overlap_b", &Evidence::overlap_b},
    {"seen_points", &Evidence::seen_points},
    {"freespace_violation", &Evidence::freespace_violation},
    {"worst_place_violation", &Evidence::worst_place_violation},
    {"farther_violation", &Evidence::farther_violation},
    {"freespace_explained", &Evidence::freespace_explained},
    {"worst_place_explained", &Evidence::worst_place_explained},
    {"farther_explained", &Evidence::farther_explained},
    {"rock_in_common", &Evidence::rock_in_common},
    {"weakest_hold", &Evidence::weakest_hold},
    {"end_on_match", &Evidence::end_on_match},
    {"descriptors_compared", &Evidence::descriptors_compared},
    {"descriptors_alike", &Evidence::descriptors_alike},
    {"tilt_deg", &Evidence::tilt_deg},
    {"support", &Evidence::support},
    {"runner_up", &Evidence::runner_up},
    {"probability_if_unique", &Evidence::probability_if_unique},
}};

/// The rim of a patch, a tenth of its points, is excused with it.
double unexcused(double violation, double explained, const Evidence& e) {
  constexpr double with_rim = 1.1;
  return std::max(0.0, violation - excused_by_changes(e) * with_rim * explained);
}

/// What lies up to 25 m from the path is looked at. (With 10 or 50 m for what lies beyond its ends, a few right
/// placements fewer stand above the wrong ones.)
double looked_at_m(const Evidence& e) {
  constexpr double beyond_ends_m = 35;
  return e.overlap_m + beyond_ends_m;
}

}  // namespace

double rock_per_metre(const Evidence& e) { return e.rock_in_common / looked_at_m(e); }

double rock_as_dense(const Evidence& then, const Evidence& now) {
  return then.rock_in_common > hardly_any_rock ? rock_per_metre(then) * looked_at_m(now) : then.rock_in_common;
}

double excused_by_changes(const Evidence& e) {
  return ramp(e.aliases, 1, 0) * ramp(e.repetition, copies_known, copies_known / 2) * ramp(e.look_alikes, 1, 0.5);
}

double freespace_contradiction(const Evidence& e) { return unexcused(e.freespace_violation, e.freespace_explained, e); }

double worst_place_contradiction(const Evidence& e) {
  return unexcused(e.worst_place_violation, e.worst_place_explained, e);
}

double farther_contradiction(const Evidence& e) { return unexcused(e.farther_violation, e.farther_explained, e); }

double looks_like_itself(const Evidence& e) {
  return std::clamp(std::max((e.mine_look_alikes - 0.1) / 0.2, e.look_alikes - 1), 0.0, 1.0);
}

double odds(double probability) { return probability / std::max(1 - probability, 1e-9); }

double alias_of(const Evidence& e, const Evidence& other) {
  const double share = odds(other.probability_if_unique) / std::max(odds(e.probability_if_unique), 1e-9);
  const double as_probable = std::clamp((std::log(std::max(share, 1e-9)) + 4.5) / 1.5, 0.0, 1.0),
               fits_worse = std::clamp((e.matched_share - other.matched_share - 0.04) / 0.04, 0.0, 1.0);
  return as_probable * (1 - fits_worse);
}

double runner_up_share(const Evidence& e) {
  // In drawn mines right placements with violations had no rival above 0.01; look-alikes that lack a crossing had.
  const double doubt = worst_place_contradiction(e) > 1e-3 ? 100 : 1;
  return e.probability > 0 ? doubt * odds(e.runner_up) / odds(e.probability) : 1;
}

bool convinces(const Evidence& e, const VerdictThresholds& thresholds) {
  return e.probability >= thresholds.accept_probability && runner_up_share(e) < thresholds.runner_up_share;
}

std::span<const EvidenceField> evidence_fields() { return fields; }

}  // namespace headframe
