#include "server/verification/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/verification/gates.hpp"
#include "server/verification/told_weights.hpp"
#include "server/verification/verdict_weights.hpp"

namespace headframe {
namespace {

bool hardly_held(const Evidence& e) { return e.weakest_hold < held_well; }

/// Where the mine repeats itself, exact copies pass every local test; only a longer overlap tells them apart. Costs at
/// most 4.1 for each 42 m demanded.
double missing_overlap(const Evidence& e) {
  const double asked_m = asked_overlap_m(e);
  if (asked_m <= 0) return 0;
  const double most = 0.34 * asked_m / asked_first_m;
  return 12 * std::max(-most, std::min(0.0, e.overlap_m / asked_m - 1));
}

/// Among look-alikes each metre missing from asked_among_look_alikes_m() costs 0.1. The cost is limited to 1.5, or
/// right placements of 28 m among copies would wait. Among many look-alikes (fully from 4.3 on, not at all up to 2.7)
/// the limit rises by 0.3 for each metre below 50 (70 from eighteen look-alikes on), or below 28 if no descriptors were
/// compared or they are nearly equal. Among the drives through a mine of equal tunnels, many of them with many
/// look-alikes, four right placements of 25 to 47 m reached 0.9, and six copies.
double short_among_look_alikes(const Evidence& e) {
  const double many = std::clamp((e.look_alikes - 2.7) / 1.6, 0.0, 1.0);
  const double more_m = 22 + 2 * std::clamp(e.look_alikes - 8, 0.0, 10.0);
  const double told_m = 28 + descriptors_leave_doubt(e) * more_m;
  const double most = 1.5 + 0.3 * many * std::max(0.0, told_m - e.overlap_m);
  return std::max(-most, 0.1 * std::min(0.0, e.overlap_m - asked_among_look_alikes_m(e)));
}

/// Limited to two and a half halvings, because two lidars that look into the same rock from paths that never meet share
/// no path at all. The only wrong placement under 10 m that was otherwise convincing (7 m, in a cave) is tilted, see
/// leans().
double halvings_below(double metres, const Evidence& e) {
  return std::clamp(std::log2(std::max(e.overlap_m, 1e-3) / metres), -2.5, 0.5);
}

/// The training data has too few copies of a single tile, which are the likelier the shorter an overlap is: each
/// halving below 30 m costs 0.5.
double shared_path(const Evidence& e) { return 0.5 * halvings_below(30, e); }

/// 1 up to 8 m of shared path, 0 from 10 m on.
double hardly_shared(const Evidence& e) { return std::clamp((10 - e.overlap_m) / 2, 0.0, 1.0); }

/// Below 10 m each halving costs 1 more; only half of it where no place looks like another. Where the walls hold a
/// placement of hardly any path loosely (in full up to .045, not at all from .052 on), another 1.5: short pieces of
/// tunnel fit at many places. Of those below 10 m, without descriptors, that reached .9, all four held by less than
/// .045 were wrong. Not part of the fit, because the fitted bias would compensate for it.
double hardly_any_path(const Evidence& e) {
  const double loose = std::clamp((0.052 - e.weakest_hold) / 0.007, 0.0, 1.0);
  return (0.5 + 0.5 * places_look_alike(e)) * std::min(0.0, halvings_below(10, e)) - 1.5 * loose * hardly_shared(e);
}

/// Several places along a hundred metres that all agree, while the walls hold the placement, are no coincidence.
double long_overlap(const Evidence& e) {
  const bool all_agree = e.places_agreeing >= e.places && !hardly_held(e);
  return all_agree ? 0.5 * std::clamp(e.overlap_m / 60 - 1, 0.0, 1.0) : 0;
}

/// Detects copies whose end was not driven through: up to 0.002 costs nothing, 0.003 costs 2.5, 0.005 costs 6. Measured
/// only if everything else convinces, so it is not part of the fit. In drawn mines all 42 right placements had less
/// than 0.0025; 39 of 56 wrong ones in mines of copies, which nothing nearby contradicted, had more than 0.003.
double ends_farther_off(const Evidence& e) {
  return -20 * std::log10((std::max(farther_contradiction(e), 2e-3) + 1e-3) / 3e-3);
}

/// At right placements in all worlds 28 % and more of the points had a partner; where paths run side by side with rock
/// between them a drawn mine had 14 %. Each halving below 30 % costs 5; below 40 % where hardly any path is shared,
/// because a wrong one of 8 m had 28 %; of 74 right ones, many of which wait for other reasons, 44 had 40 % and more.
/// Not part of the fit, whose data has no such rows.
double few_points_meet(const Evidence& e) {
  const double asked = 0.3 + 0.1 * hardly_shared(e);
  return -5 * std::max(0.0, std::log2(asked / std::max(e.inlier_fraction, 0.02)));
}

/// The surfaces that both could see have to match if little else speaks: where up to three places do (less with four,
/// nothing from five on), each tenth below 72 % costs 1.2; where hardly any path is shared, each tenth below 74 % costs
/// 2.8. At four wrong ones, for which all else spoke, 60 to 68 % matched. Right ones are not all better: of 74 of less
/// than 10 m, 38 had 74 % and more. Not part of the fit.
double surfaces_do_not_match(const Evidence& e) {
  const double few_places = std::clamp((5 - e.places) / 2, 0.0, 1.0);
  return -std::max({0.0, 12 * few_places * (0.72 - e.matched_share), 28 * hardly_shared(e) * (0.74 - e.matched_share)});
}

/// Drift moves places apart, and along a tunnel that hardly holds them they slide by less than a metre. Each doubling
/// beyond 1.2 m, plus 1 % of the overlap, costs 4. At right placements 1.1 m and less; at one that was 2 m off along a
/// tunnel, 2.2 m. Not part of the fit.
double places_lie_apart(const Evidence& e) {
  return -4 * std::max(0.0, std::log2(e.spread_m / (1.2 + 0.01 * e.overlap_m)));
}

/// Both maps are level, but the last stage of registration does not use that, so accidental fits are tilted. In worlds
/// without copies 12 of 32 wrong placements that almost nothing contradicted were tilted by more than half a degree,
/// and 2 of 112 right ones. Each doubling beyond that costs 3. Not part of the fit.
double leans(const Evidence& e) { return -3 * std::max(0.0, std::log2(std::max(e.tilt_deg, 1e-3) / 0.5)); }

/// 1 where a place disagrees though the walls hold the placement (fully from .05 on, not up to .03).
double held_place_disagrees(const Evidence& e) {
  const double held = std::clamp((e.weakest_hold - 0.03) / 0.02, 0.0, 1.0);
  return held * std::clamp(e.places - e.places_agreeing, 0.0, 1.0);
}

/// 1 where places lie apart (fully from 0.8 m on, not up to 0.6) though the walls hold the placement (fully from .02
/// on, not up to .017).
double held_places_lie_apart(const Evidence& e) {
  const double held = std::clamp((e.weakest_hold - 0.017) / 0.003, 0.0, 1.0);
  return held * std::clamp((e.spread_m - 0.6) / 0.2, 0.0, 1.0);
}

/// 1 up to a weakest hold of .08, 0 from .11 on.
double held_loosely(const Evidence& e) { return std::clamp((0.11 - e.weakest_hold) / 0.03, 0.0, 1.0); }

/// 1 for a straight tunnel, whose walls hardly hold the placement along it (up to .04, not from .05 on).
double straight(const Evidence& e) { return std::clamp((0.05 - e.weakest_hold) / 0.01, 0.0, 1.0); }

/// How far a copy has to be reckoned with, 0 to 1: where copies were seen; over less than 25 m (in full 20) where the
/// walls hold the placement loosely; and in a straight tunnel if the descriptors of eight keyframes and more agree to
/// less than .76 (in full .72). Of placements over 8 to 25 m against which nothing else speaks, 25 of 77 held by .05 to
/// .08 are copies of a tile or two, and 3 of 126 held better. In a straight tunnel, two copies of 66 and 80 m agreed to
/// .70; right ones to as little only where the mine shows no look-alikes.
double copy_expected(const Evidence& e) {
  const double a_tile = held_loosely(e) * std::clamp((25 - e.overlap_m) / 5, 0.0, 1.0);
  const double unlike = std::clamp((0.76 - e.descriptors_alike) / 0.04, 0.0, 1.0) *
                        std::clamp((e.descriptors_compared - 4) / 4, 0.0, 1.0);
  return std::max({copies_shown(e), a_tile, straight(e) * unlike});
}

/// Overlap that is missing where places lie apart among look-alikes though the walls hold the placement (fully from
/// .023 on, not up to .018), because drift explains no such distance over a short overlap. 45 m are demanded from 0.35
/// m and 1.4 look-alikes on (nothing up to 0.2 m or one); 36 m from 0.46 m and 0.3 similar places on (nothing up to
/// 0.36 m or .15), unless the descriptors are nearly equal (.95 to .97). Of placements that reached .9 without this,
/// five of 16 to 27 m were copies, and two of 27 and 32 m right.
double missing_where_look_alikes_lie_apart(const Evidence& e) {
  const auto ramp = [](double value, double none, double all) {
    return std::clamp((value - none) / (all - none), 0.0, 1.0);
  };
  const double similar = ramp(e.similar_places, 0.15, 0.3) * ramp(e.descriptors_alike, 0.97, 0.95);
  return ramp(e.weakest_hold, 0.018, 0.023) *
         std::max({0.0, ramp(e.look_alikes, 1, 1.4) * ramp(e.spread_m, 0.2, 0.35) * (45 - e.overlap_m),
                   similar * ramp(e.spread_m, 0.36, 0.46) * (36 - e.overlap_m)});
}

/// In a mine that looks like itself, one pair of sessions cannot show how many copies there are. So it demands the
/// longest of these overlaps, and each metre missing costs 0.3:
/// - where a copy has to be reckoned with (copy_expected), 60 m if the descriptors agree to .90 or less, falling to
///   nothing at .93; 40 m more if it is nearly straight (the walls hardly hold it along the tunnel);
/// - there, and from four look-alikes on, or about one where all sessions together show some (fully from 0.38 per 100 m
///   on, not up to 0.3), 56 m if they agree to .94 or less, falling to nothing at .955, because one of many copies may
///   have such descriptors; 20 m more if it is nearly straight (where all sessions show some: falling to nothing at
///   .965, because a copy of 30 m had .951), and 2 m for each look-alike beyond seven;
/// - 60 m if a place disagrees though the walls hold it (fully from .05 on, not up to .03), or if places lie apart
///   though the walls hold them: each piece of a copy fits at its own place. Of those that reached .85, copies of 27 to
///   58 m lay apart by 0.56 to 1.41 m; right ones by 0.59 m at most, but for one of 1.10 m, for which the descriptors
///   do not speak either, and two of 0.72 and 0.94 m that slide along a tunnel;
/// - 60 m if points scatter (fully from .132 m on, not up to .112), as at an accepted copy of 50 m; at 86 accepted
///   right ones of 19 to 125 m among more than two look-alikes, by .112 m at most.
/// Wherever look-alikes lie apart, each metre of missing_where_look_alikes_lie_apart() costs as much. Set by hand on
/// worlds of equal tunnels. Of the placements of 25 to 57 m there for which all else spoke, 21 of 44 were copies. With
/// descriptors of .91 to .95, copies of 24, 36, 39, 41, 44, 44, 50, 53, 58, 66, 83 and 84 m were accepted; and one of
/// 37 m, .96, where one place of six disagreed, as at none of the right ones that the walls hold.
double short_in_mine_of_copies(const Evidence& e) {
  const double compared = std::min(1.0, e.descriptors_compared);
  const double differ = std::clamp((0.93 - e.descriptors_alike) / 0.03, 0.0, 1.0);
  const double of_mine = std::clamp((e.mine_look_alikes - 0.3) / 0.08, 0.0, 1.0);
  const double copies = std::max(of_mine * std::clamp((e.look_alikes - 0.95) / 0.4, 0.0, 1.0),
                                 std::clamp((e.look_alikes - 3.5 + of_mine) / 0.8, 0.0, 1.0));
  const double by_chance =
      copies * std::clamp((0.955 + 0.01 * of_mine * straight(e) - e.descriptors_alike) / 0.015, 0.0, 1.0);
  const double many_m = 2 * std::clamp(e.look_alikes - 7, 0.0, 10.0);
  const double scattered = std::clamp((e.rmse_m - 0.112) / 0.02, 0.0, 1.0);
  const double of_copies_m = std::max(differ * (60 + 40 * straight(e)), by_chance * (56 + 20 * straight(e) + many_m));
  const double told_m = std::max(60 * held_place_disagrees(e), 60 * held_places_lie_apart(e));
  const double missing_m = std::max(
      {0.0, told_m - e.overlap_m, copy_expected(e) * (of_copies_m - e.overlap_m), scattered * (60 - e.overlap_m)});
  return -0.3 * compared * std::max(looks_like_itself(e) * missing_m, missing_where_look_alikes_lie_apart(e));
}

/// If at most one descriptor was compared, which says little, only the length of the overlap and how well the walls
/// hold it tell a copy from the place itself. Where places look alike (fully from one look-alike on, not up to 0.4) or
/// the mine looks like itself, each metre below 28 m costs 0.3; below 60 m where the walls hold it loosely (fully up to
/// .06, not from .07 on), there also if only a place disagrees; below 15 m more from three look-alikes on (not up to
/// two) where it is held by .07 and less (not from .08 on). Below 15 m, whatever looks alike, each metre costs as much
/// if places lie apart (fully from 0.2 m on, not up to 0.1) and the walls do not hold them firmly (held_loosely()):
/// drift explains no such distance there. Set by hand on crossed drives through five worlds, of robots with descriptors
/// of two families: eight copies of 17 to 58 m were accepted, all held by less than .07; at one of them nothing looked
/// alike, but a place disagreed. A ninth, of 6 m and held by .071, had a tenth of a look-alike and places 0.24 m apart.
/// Of the right ones below 15 m that reached .9, one is held by less than .11 and lies more than 0.1 m apart: in a
/// cave, 11 m, held by .104.
double short_without_descriptors(const Evidence& e) {
  const double absent = std::clamp(2 - e.descriptors_compared, 0.0, 1.0);
  const double loosely = std::clamp((held_firmly - e.weakest_hold) / 0.01, 0.0, 1.0);
  const double doubt = std::max(
      {looks_like_itself(e), std::clamp((e.look_alikes - 0.4) / 0.6, 0.0, 1.0), loosely * held_place_disagrees(e)});
  const double many = std::clamp(e.look_alikes - 2, 0.0, 1.0) * std::clamp((0.08 - e.weakest_hold) / 0.01, 0.0, 1.0);
  const double asked_m = 28 + 32 * loosely + 15 * many;
  const double apart = std::clamp((e.spread_m - 0.1) / 0.1, 0.0, 1.0) * held_loosely(e);
  return -0.3 * absent *
         std::max(doubt * std::max(0.0, asked_m - e.overlap_m), apart * std::max(0.0, 15 - e.overlap_m));
}

/// If another placement fits, places look alike, or places lie apart though the walls hold them, the descriptors of a
/// short overlap have to decide. Of 11 such right placements in six kinds of mines, with less than 36 m and at least
/// four descriptors, 10 had a similarity of 0.85 and more, and one 0.77, over 32 m; a smooth tunnel was merged wrongly
/// over 23 m, with 0.76 to 0.78 from five. Costs 6 at most, with five or more descriptors, from a quarter of a look-
/// alike on: with half of that cost a copy of 28 m in equal tunnels, whose places lie 0.77 m apart, 0.69 from five,
/// reached 0.91. Look-alikes count only where copies were seen or the walls hold the placement loosely: two right ones
/// of rough tunnels, of 16 and 30 m, had a fifth of one. Set by hand on these; not part of the fit.
double hardly_told_apart(const Evidence& e) {
  const double alike = std::max(copies_shown(e), held_loosely(e)) * e.look_alikes / 0.25;
  const double likeness = std::min(1.0, std::max({e.aliases / 0.2, alike, held_places_lie_apart(e)})),
               compared = std::clamp((e.descriptors_compared - 3) / 2, 0.0, 1.0),
               is_short = std::clamp((36 - e.overlap_m) / 10, 0.0, 1.0);
  const double differ = std::clamp((0.83 - e.descriptors_alike) / 0.07, 0.0, 1.0);
  return std::min(
      {-6 * likeness * compared * is_short * differ, short_in_mine_of_copies(e), short_without_descriptors(e)});
}

/// Where the robots shared little path, walls farther off tell, too. The score of a piece of one session's wall map on
/// the other's (Evidence::support; fully from 150 cells of half a metre on, not up to 100) covers more than the
/// submaps. It takes back up to 4 of what a short overlap costs, unless places or the mine look alike, or the walls
/// near the paths hold it loosely (fully from .08 on, not up to .05), since walls along a tunnel match anywhere. Of
/// placements below 30 m with a probability of .05 to .9, 20 of 25 right ones scored 115 and more, and 4 of 15 wrong
/// ones. Of 8705 judged placements in five worlds and generated mines, six more right ones reach .9, and the likeliest
/// wrong one that gains by it has .46. Where hardly any path is shared, a score that is known and lower costs 1 (fully
/// up to 90, not from 100 on): two tunnels of a cave, 11 m apart, seen from each other only through a gap that both
/// have, had 90. Set by hand on most of these; not part of the fit.
double walls_match(const Evidence& e) {
  const double costs =
      std::min(0.0, shared_path(e)) + few_points_meet(e) + surfaces_do_not_match(e) + hardly_any_path(e);
  const double distinct = std::clamp((0.75 - e.look_alikes) / 0.5, 0.0, 1.0) *
                          std::clamp((0.3 - e.mine_look_alikes) / 0.2, 0.0, 1.0) * std::clamp(1 - e.aliases, 0.0, 1.0);
  const double held = std::clamp((e.weakest_hold - 0.05) / 0.03, 0.0, 1.0);
  const double hardly = e.support > 0 ? hardly_shared(e) * std::clamp((100 - e.support) / 10, 0.0, 1.0) : 0;
  return std::min(-costs, 4 * held * distinct * std::clamp((e.support - 100) / 50, 0.0, 1.0)) - hardly;
}

}  // namespace

std::array<VerdictTerm, verdict_term_count> verdict_terms(const Evidence& e) {
  // Each value is 0 if nothing speaks against the placement, scaled so that right placements of many worlds lie close
  // together.
  const double n = e.descriptors_compared, few = std::min(10.0, n);  // ten count in full, one next to nothing
  const double least_alike = asked_alike(e);
  // At a crossing the robots look in different directions; if no place looks like another, three differing descriptors
  // say little.
  const double crossing = std::clamp((8 - n) / 5, 0.0, 1.0) * (1 - places_look_alike(e));
  const double telling = 1 - 0.75 * crossing;
  return {{
      {"free space contradicts", -std::log10((freespace_contradiction(e) + 1e-3) / 1e-3)},
      {"one place contradicts", -std::log10((worst_place_contradiction(e) + 1e-3) / 1e-3)},
      {"surfaces lie apart", -std::max(0.0, std::log10((e.residual_m + 0.01) / 0.075))},
      {"points scatter about the surfaces", -std::max(0.0, std::log10(std::max(e.rmse_m, 0.01) / 0.12))},
      {"places disagree", -(1 - e.places_agreeing / std::max(1.0, e.places))},
      {"nothing holds it along the tunnel", hardly_held(e) ? std::min(0.0, e.end_on_match / ends_meet - 1) : 0},
      {"descriptors differ", telling * 1.1 * few * few / (few + 1) * std::min(0.0, e.descriptors_alike - least_alike)},
      {"descriptors agree", n / (n + 3) * std::max(0.0, e.descriptors_alike - 0.6)},
  }};
}

LogOdds log_odds(const Evidence& e) {
  LogOdds out;
  out.bias = verdict_bias;
  const auto terms = verdict_terms(e);
  for (std::size_t i = 0; i < terms.size(); ++i)
    out.contributions[i] = {terms[i].name, verdict_weights[i] * terms[i].value};
  out.contributions[verdict_term_count] = {"overlap is short for a mine that repeats itself",
                                           std::min(missing_overlap(e), short_among_look_alikes(e))};
  out.contributions[verdict_term_count + 1] = {"path that is shared", shared_path(e)};
  out.contributions[verdict_term_count + 2] = {"long overlap agrees", long_overlap(e)};
  out.contributions[verdict_term_count + 3] = {"free space farther off contradicts", ends_farther_off(e)};
  out.contributions[verdict_term_count + 4] = {"few points meet", few_points_meet(e)};
  out.contributions[verdict_term_count + 5] = {"places look alike", -places_look_alike(e)};
  out.contributions[verdict_term_count + 6] = {"gravity disagrees", leans(e)};
  out.contributions[verdict_term_count + 7] = {"places lie apart", places_lie_apart(e)};
  out.contributions[verdict_term_count + 8] = {"surfaces do not match", surfaces_do_not_match(e)};
  out.contributions[verdict_term_count + 9] = {"hardly any path is shared", hardly_any_path(e)};
  out.contributions[verdict_term_count + 10] = {"descriptors hardly tell it from another place", hardly_told_apart(e)};
  out.contributions[verdict_term_count + 11] = {"walls farther off match", walls_match(e)};
  return out;
}

double LogOdds::taken_as_given() const {
  return std::accumulate(contributions.begin() + verdict_term_count, contributions.end() - 3, 0.0,
                         [](double sum, const VerdictTerm& t) { return sum + t.value; });
}

double LogOdds::sum() const {
  return std::accumulate(contributions.begin(), contributions.end(), bias,
                         [](double sum, const VerdictTerm& t) { return sum + t.value; });
}

double probability(RegistrationStatus status, const Evidence& e) {
  if (status == RegistrationStatus::too_little_overlap) return 0;
  if (e.tilt_deg > most_tilt_deg) return 0;
  const double z = log_odds(e).sum();
  const double p = 1 / (1 + std::exp(-z));
  // A placement that slides along the tunnel can look right at many places: at most a candidate.
  return status == RegistrationStatus::converged ? p : 0.4 * p;
}

double calibrated(const Evidence& e, const VerdictThresholds& thresholds) {
  const double p = e.probability;
  if (p >= thresholds.accept_probability) return p;
  const double right_all_the_same = told_base + told_height * std::pow(e.probability_if_unique, told_power);  // odds
  const double odds = p / (1 - p) + right_all_the_same * (1 - p);
  return std::min(odds / (1 + odds), 0.999 * thresholds.accept_probability);
}

}  // namespace headframe
