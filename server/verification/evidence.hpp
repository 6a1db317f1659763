#pragma once
// The evidence for and against a placement, and the thresholds of the verdict.

#include <span>
#include <string_view>

namespace headframe {

/// Thresholds of the verdict; defaults live only here (the rest is in merge/merge_config.hpp).
struct VerdictThresholds {
  double accept_probability = 0.9;     // a merge is published at or above this ...
  double runner_up_share = 0.1;        // ... if its runner-up's odds stay below this share of its own
  double candidate_probability = 0.2;  // shown as a candidate at or above this
  double least_path_m = 50;            // a growing session is not tried before it is this long, or its robot asks
};

/// Everything the verdict is based on. NaN: not measured. evidence_fields() lists the members by name, so that store,
/// API and reports need not repeat them.
struct Evidence {
  double probability = 0;      // that T_a_b is right; of an alignment calibrated()
  double pairs = 0;            // keyframes within 10 m of a keyframe of the other session, mean of both sessions
  double places = 0;           // spread over the overlap, where both saw some rock; each registered independently
  double places_agreeing = 0;  // places whose own registration agrees with T_a_b up to drift
  double inlier_fraction = 0;  // share of the longer session's points at these places that have a partner
  double matched_share = 0;    // of the points about which the other map can say anything: share on its surface
  double rmse_m = 0;           // of the inliers, along the normals
  double own_scatter_m = 0;    // of each session's own points about its own surfaces there; 0: not measured
  double residual_m = 0;       // median distance from the other's surface, with each place registered independently
  double spread_m = 0;         // root mean square of how far the places' own registrations differ from T_a_b
  double overlap_m = 0;        // shared path, mean of both: in full within 4 m of the other path, fading out at 16 m
  double path_m = 0;           // path of both sessions when the pair was last judged as a whole
  double awaited_m = 0;        // path that a growing session still has to drive before the placement is published
  double aliases = 0;          // copies of the overlap that hold over more than one place: the mine repeats itself
  double repetition = 0;       // copies that all sessions of the database show of themselves, per 100 m of their path
  /// At how many other placements one place, taken alone, fits as a copy of the rock would (likeness()): of the two
  /// sessions on each other, and of each on itself near the overlap. At right placements 0 in a cave, 1 in rough
  /// tunnels, .3 to 13 among equal tunnels.
  double look_alikes = 0;
  /// Those to be expected of the overlap per 100 m of path: as many as all sessions of the database show of themselves,
  /// and the fewer, the more path these two drove without a place like it (expected_look_alikes()).
  double mine_look_alikes = 0;
  double similar_places = 0;  // the same of both sessions as a whole, with up to 1.2 % contradicted (resemblance())
  /// Similar places per 100 m of path, of the two sessions or of all in the database, whichever has more. Where less
  /// than 200 m are known of the mine, the rest counts as if it held half a one per 100 m. Negative: not known.
  double mine_similar_places = -1;
  double overlap_a = 0;              // share of a's points near the overlap that b's rays met
  double overlap_b = 0;              // the same for b's points and a's rays
  double seen_points = 0;            // points that support the placement, both ways
  double freespace_violation = 0;    // share of points of one map that the other's rays pass through
  double worst_place_violation = 0;  // the same at the place that contradicts most
  double farther_violation = 0;      // the same up to 25 m from a place instead of 15; 0 unless it was looked at
  double freespace_explained = 0;    // the part of freespace_violation that changes of the mine explain: patches with
  double worst_place_explained = 0;  // an edge, between sessions recorded more than an hour apart; likewise for the
  double farther_explained = 0;      // other two
  double weakest_hold = 0;  // smallest eigenvalue of the normals' mean outer product: 0 slides freely, 1/3 is held
  /// Cubes of a metre in which both met rock, up to 25 m from the spots looked at; the mean of both, at least where
  /// clouds are missing. 0: not looked at, which says nothing. hardly_any_rock: not either, and as little is assumed.
  double rock_in_common = 0;
  double end_on_match = 0;  // share of the surfaces facing along the weakest axis that meet such a surface of the other
  double descriptors_compared = 0;   // keyframes of the longer session within 3 m of one of the other's
  double descriptors_alike = 0;      // their mean similarity, 0 to 1 (Agreement::mean)
  double tilt_deg = 0;               // disagreement about gravity after registration
  double support = 0;                // wall map score of the hypothesis it came from
  double runner_up = 0;              // probability of the best different placement
  double probability_if_unique = 0;  // what it would be if no place looked like another
};

/// held_well: weakest hold from which on nothing slides along a tunnel. ends_meet: end-on match from which on a place
/// in a tunnel with less hold can be told from its neighbours. In the recordings right placements match 0.22 and more,
/// wrong ones 0.07.
inline constexpr double held_well = 0.03, ends_meet = 0.12;

/// Evidence::rock_in_common where it is not looked at, though a placement that shares little rock is to be doubted.
inline constexpr double hardly_any_rock = 1;

/// Repetition from which on the database is known to hold copies. Over all recordings at once it is 0.05.
inline constexpr double copies_known = 0.15;

/// Evidence::rock_in_common per metre of the tunnel that was looked at: the shared path, and what is seen beyond its
/// ends.
double rock_per_metre(const Evidence& evidence);

/// The rock in common that `now` has if it is as dense as `then`, when it was last looked at; more path may be shared.
double rock_as_dense(const Evidence& then, const Evidence& now);

/// How far changes of the mine excuse contradictions, 0 to 1. Not at all where the mine repeats itself, because the end
/// of a copy looks like a tunnel that was driven on.
double excused_by_changes(const Evidence& evidence);

/// The violations that count against the placement: all except those that changes explain and excuse, and the rim of
/// their patches (a tenth more).
double freespace_contradiction(const Evidence& evidence);
double worst_place_contradiction(const Evidence& evidence);
double farther_contradiction(const Evidence& evidence);

/// How far the mine is known to look like itself, 0 to 1. By what all sessions show of themselves: 0 up to 0.1 look-
/// alikes per 100 m of path, 1 from 0.3 on. Or by the look-alikes of the two sessions: 0 up to one, 1 from two on. Of
/// pairs of drives, 29 in three worlds without copies had 0.2 per 100 m at most, 20 of them less than 0.05; of 20 in
/// two worlds of equal pieces, 18 had more than 0.25.
double looks_like_itself(const Evidence& evidence);

/// p / (1 - p), at most 1e9.
double odds(double probability);

/// How much another placement makes this one doubtful, 0 to 1: unless the mine repeats itself, it is nearly as probable
/// (fully with a twentieth of the odds, not at all with a ninetieth), and it fits as well. Copies of a tile match up to
/// 4 % worse than the right placement, because the rock around them differs. In a mine of pillars, rivals that matched
/// 7 and 14 % less made a right placement wait; in a surveyed mine, one with a sixtieth of the odds.
double alias_of(const Evidence& evidence, const Evidence& other);

/// Odds of the runner-up over those of this placement, times one hundred if free space contradicts this one. Near 1:
/// the two cannot be told apart.
double runner_up_share(const Evidence& evidence);

/// Whether the placement is probable enough, and clearly more probable than its runner-up.
bool convinces(const Evidence& evidence, const VerdictThresholds& thresholds);

struct EvidenceField {
  std::string_view name;
  double Evidence::*member;
};
std::span<const EvidenceField> evidence_fields();

}  // namespace headframe
