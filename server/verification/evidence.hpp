#pragma once
// What was measured of a placement, for it and against it, and how much of it a verdict asks for.

#include <span>
#include <string_view>

namespace headframe {

/// From when on a placement counts; defaults live only here (merge/merge_config.hpp has the rest).
struct VerdictThresholds {
  double accept_probability = 0.9;     // a merge is published at or above this ...
  double runner_up_share = 0.1;        // ... when its runner-up's odds stay below this share of its own
  double candidate_probability = 0.2;  // shown as a candidate at or above this
  double least_path_m = 50;            // a growing session waits until it has come so far, or its robot asks
};

/// Everything the verdict was made from. NaN: not measured. evidence_fields() lists the members by name, so that store,
/// API and reports never repeat them.
struct Evidence {
  double probability = 0;      // calibrated, that T_a_b is right
  double pairs = 0;            // keyframes that lie within 10 m of one of the other's, mean of both sessions
  double places = 0;           // spread over the overlap, where both saw some rock; each registered by itself
  double places_agreeing = 0;  // ... that stayed within the drift of T_a_b
  double inlier_fraction = 0;  // of the longer session's points where they meet, with a partner in the other
  double matched_share = 0;    // of those of them that the other's map can speak of, that lie on its surface
  double rmse_m = 0;           // of the inliers, along the normals
  double residual_m = 0;       // median distance from the other's surface, where each place was registered by itself
  double spread_m = 0;         // how far the places would have moved by themselves, root mean square
  double overlap_m = 0;   // path along which the other passes, mean of both: in full within 4 m, fading out at 16 m
  double path_m = 0;      // of both sessions when the pair was last judged as a whole
  double awaited_m = 0;   // path that a session which still grows has to come along before the placement is told
  double aliases = 0;     // other placements whose first place, taken alone, looks right: the mine repeats itself
  double repetition = 0;  // copies that all sessions of the database show of themselves, per 100 m of their path
  /// Other placements at which a place fits, taken alone, as a copy of the rock would (likeness()): of the two on each
  /// other, and of each on itself. At right placements 0 in a cave, 1 in rough tunnels, .3 to 13 among equal tunnels.
  double look_alikes = 0;
  double mine_look_alikes = 0;  // that all sessions of the database show of themselves, per 100 m of their path
  double overlap_a = 0;         // share of a's points near the overlap that b's rays met, and the other way round
  double overlap_b = 0;
  double seen_points = 0;            // that speak for it, both ways
  double freespace_violation = 0;    // points of one map that the other's rays pass through / points that say anything
  double worst_place_violation = 0;  // the same at the place that contradicts most
  double farther_violation = 0;      // the same up to 25 m from a place instead of 15; 0 unless the mine repeats itself
  double freespace_explained = 0;  // of these, what changes of the mine explain: points that form patches with an edge,
  double worst_place_explained = 0;  // where the sessions were recorded more than an hour apart
  double farther_explained = 0;
  double weakest_hold = 0;  // smallest eigenvalue of the normals' mean outer product: 0 slides freely, 1/3 is held
  double end_on_match = 0;  // share of surfaces that face along the weakest axis and meet one of the other's that does
  double descriptors_compared = 0;   // keyframes of the longer session within 3 m of one of the other's
  double descriptors_alike = 0;      // ... how alike they are, 0 to 1 (Agreement::mean)
  double tilt_deg = 0;               // gravity disagreement after registration
  double support = 0;                // wall map score of the hypothesis it came from
  double runner_up = 0;              // probability of the best different hypothesis
  double probability_if_unique = 0;  // what it would be with no aliases, no repetition and no look-alikes
};

/// Weakest hold from which on nothing slides along a tunnel, and the end-on match from which on a place of a tunnel
/// that holds less is told from its neighbours: in the recordings right placements match 0.22 and more, wrong ones
/// 0.07.
inline constexpr double held_well = 0.03, ends_meet = 0.12;

/// Repetition from which on the database is known to hold copies: over all recordings at once it is 0.05.
inline constexpr double copies_known = 0.15;

/// How far changes of the mine excuse what contradicts, 0 to 1: not where the mine repeats itself, for a copy ends like
/// a drift that was driven on.
double excused_by_changes(const Evidence& evidence);

/// The violations that speak against the placement: all but what changes explain and excuse.
double freespace_contradiction(const Evidence& evidence);
double worst_place_contradiction(const Evidence& evidence);
double farther_contradiction(const Evidence& evidence);

/// How far places look alike, 0 to 1: 0 up to one look-alike, 1 from two and a half on or with an alias. Where it is 0,
/// what agrees is believed on less: of 340 wrong placements there none reached .85 then, and where it is 1 three had
/// reached .9 before.
double places_look_alike(const Evidence& evidence);

/// How far the mine is known to look like itself, 0 to 1: by what all sessions show of themselves, 0 up to one tenth of
/// a look-alike in 100 m of path, 1 from three tenths on; or by look-alikes of the two, 0 up to one, 1 from two on. Of
/// pairs of drives 29 in three worlds without copies had 0.2 in 100 m at most, 20 of them less than 0.05, and of 20 in
/// two worlds of equal pieces 18 had more than 0.25.
double looks_like_itself(const Evidence& evidence);

/// How alike the descriptors have to be: .72; .85 where the mine repeats or looks like itself, or places look alike. At
/// right placements of drawn mines they were .76 and more but for one, .80 in mines of copies, on a campus .73; of
/// copies that were merged wrongly .62 to .69, and of one of 66 m that had no look-alike of its own .64.
double asked_alike(const Evidence& evidence);

/// The aliases as they count: twice when the descriptors are .72 alike or less (at .74, and counted once, a copy of a
/// crosscut was merged over 37 m of smooth tunnel). Alike ones take nothing off: while they halved an alias, three
/// copies of 25 to 34 m beside one were merged in a mine of equal tunnels, and as many right ones.
double counted_aliases(const Evidence& evidence);

/// How far descriptors that were compared leave room for a copy, 0 to 1: not at all from .97 alike on, in full at .88
/// and less over four keyframes and more. At right placements of the recordings among look-alikes they were .95 to .97,
/// at copies .83 to .93, but for two of .96 and .97.
double descriptors_leave_doubt(const Evidence& evidence);

/// For the first alias that counts, and for each further one. With 30 m two mines of the same 20 m tiles were merged
/// over 24 m; of six placements of 25 to 39 m beside an alias in a mine of equal tunnels three were copies.
inline constexpr double asked_first_m = 42, asked_further_m = 20;

/// Overlap that is asked for where the mine repeats itself. Where all sessions together show copies,
/// up to 70 m without any alias: the copy that would be merged wrongly need not have been driven through twice. At most
/// 100 m.
double asked_overlap_m(const Evidence& evidence);

/// Overlap that is asked for among look-alikes (Evidence::look_alikes). Of some 340 pairs of drives, most through
/// two mines of equal pieces, 17 copies of 8 to 84 m were believed without it, and 8 of 21 to 53 m are with it.
double asked_among_look_alikes_m(const Evidence& evidence);

/// Odds of the runner-up over this one's, a hundred times that where free space contradicts this one. Near 1: not told
/// apart.
double runner_up_share(const Evidence& evidence);

/// Probable enough, and told from its runner-up.
bool convinces(const Evidence& evidence, const VerdictThresholds& thresholds);

struct EvidenceField {
  std::string_view name;
  double Evidence::*member;
};
std::span<const EvidenceField> evidence_fields();

}  // namespace headframe
