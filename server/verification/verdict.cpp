#include "server/verification/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "server/verification/gates.hpp"
#include "server/verification/verdict_weights.hpp"

namespace headframe {
namespace {

bool hardly_held(const Evidence& e) { return e.weakest_hold < held_well; }

/// Where the mine repeats itself, exact copies pass every local test: only a longer overlap tells them apart. It costs
/// at most 4.1 for each 42 m.
double missing_overlap(const Evidence& e) {
  const double asked_m = asked_overlap_m(e);
  if (asked_m <= 0) return 0;
  const double most = 0.34 * asked_m / asked_first_m;
  return 12 * std::max(-most, std::min(0.0, e.overlap_m / asked_m - 1));
}

/// Each metre less costs 0.1, and no more than 1.5 in all, or right placements of 28 m among copies would wait; among
/// many look-alikes (in full from 4.3 on, not at all up to 2.7) 0.3 more for each metre below 50 (70 from eighteen
/// look-alikes on), or below 28 where no descriptors were compared, or they are all but the same: of drives through a
/// mine of equal tunnels, many with many others, four right placements of 25 to 47 m there reached 0.9, and six copies.
double short_among_look_alikes(const Evidence& e) {
  const double many = std::clamp((e.look_alikes - 2.7) / 1.6, 0.0, 1.0);
  const double more_m = 22 + 2 * std::clamp(e.look_alikes - 8, 0.0, 10.0);
  const double told_m = 28 + descriptors_leave_doubt(e) * more_m;
  const double most = 1.5 + 0.3 * many * std::max(0.0, told_m - e.overlap_m);
  return std::max(-most, 0.1 * std::min(0.0, e.overlap_m - asked_among_look_alikes_m(e)));
}

/// Two and a half at most: two lidars that look into the same rock from paths that never meet share no path at all. The
/// one wrong placement under 10 m for which all else spoke (7 m, in a cave) leans, see leans().
double halvings_below(double metres, const Evidence& e) {
  return std::clamp(std::log2(std::max(e.overlap_m, 1e-3) / metres), -2.5, 0.5);
}

/// What was fitted on has too few copies of a single tile, and the shorter an overlap the likelier it is one: each
/// halving below 30 m costs 0.5.
double shared_path(const Evidence& e) { return 0.5 * halvings_below(30, e); }

/// Below 10 m each halving costs 1 more, half of it where no place looks like another. The fit does not know of it, or
/// its bias would make up for it.
double hardly_any_path(const Evidence& e) {
  return (0.5 + 0.5 * places_look_alike(e)) * std::min(0.0, halvings_below(10, e));
}

/// Places along a hundred metres that all agree, where the walls hold, are no chance.
double long_overlap(const Evidence& e) {
  const bool all_agree = e.places_agreeing >= e.places && !hardly_held(e);
  return all_agree ? 0.5 * std::clamp(e.overlap_m / 60 - 1, 0.0, 1.0) : 0;
}

/// A copy that ends where it was not driven: nothing up to 0.002, 0.003 costs 2.5, 0.005 costs 6. Looked at only where
/// all else convinces, so no fit knows it. In drawn mines all 42 right placements had less than 0.0025, and of 56 wrong
/// ones in mines of copies that nothing near contradicted 39 had more than 0.003.
double ends_farther_off(const Evidence& e) {
  return -20 * std::log10((std::max(farther_contradiction(e), 2e-3) + 1e-3) / 3e-3);
}

/// Right placements of all worlds looked at had 28 % and more of the points meet, where paths run side by side with
/// rock between them a drawn mine had 14 %: each halving below 30 % costs 5. No fit knows it: it has no such rows.
double few_points_meet(const Evidence& e) {
  return -5 * std::max(0.0, std::log2(0.3 / std::max(e.inlier_fraction, 0.02)));
}

/// Both maps are level, and no registration is held to it at its end: what fits by chance leans. In worlds without
/// copies 12 of 32 wrong placements that next to nothing contradicted leaned more than half a degree, and 2 of 112
/// right ones. Each doubling beyond that costs 3. No fit knows it.
double leans(const Evidence& e) { return -3 * std::max(0.0, std::log2(std::max(e.tilt_deg, 1e-3) / 0.5)); }

/// In a mine that looks like itself a pair alone can not show how many copies there are: below 50 m descriptors have to
/// be .92 alike, or fewer metres do the better they are; 28 m do where none were compared. Each metre less costs 0.3.
/// Of drives through worlds of equal tunnels three copies of 9 to 31 m, with two look-alikes at most, reached 0.9
/// without it; it holds four right placements of 16 to 46 m back.
double short_in_mine_of_copies(const Evidence& e) {
  const double compared = std::min(1.0, e.descriptors_compared);
  const double doubt = std::clamp((0.92 - e.descriptors_alike) / 0.09, 0.0, 1.0);
  const double told_m = compared * doubt * 50 + (1 - compared) * 28;
  return -0.3 * looks_like_itself(e) * std::max(0.0, told_m - e.overlap_m);
}

/// Where another placement fits, or places look alike, the descriptors of a short overlap have to tell. Of 11 pairs of
/// six kinds of mines that were placed rightly so, over less than 36 m and with four descriptors and more, 10 were
/// alike to 0.85 and more, and one to 0.77, over 32 m; a smooth tunnel was merged wrongly over 23 m, with 0.76 to 0.78
/// of five. It costs 6 at most, with five and more descriptors. By hand, on that tunnel; no fit knows it.
double hardly_told_apart(const Evidence& e) {
  const double likeness = std::min(1.0, std::max(e.aliases / 0.2, e.look_alikes / 0.5)),
               compared = std::clamp((e.descriptors_compared - 3) / 2, 0.0, 1.0),
               is_short = std::clamp((36 - e.overlap_m) / 10, 0.0, 1.0);
  const double differ = std::clamp((0.83 - e.descriptors_alike) / 0.07, 0.0, 1.0);
  return std::min(-6 * likeness * compared * is_short * differ, short_in_mine_of_copies(e));
}

}  // namespace

std::array<VerdictTerm, verdict_term_count> verdict_terms(const Evidence& e) {
  // Each is 0 where nothing speaks against the placement, on a scale on which right ones of many worlds lie close.
  const double n = e.descriptors_compared, few = std::min(10.0, n);  // ten say it all, one next to nothing
  const double least_alike = asked_alike(e);
  // At a crossing each looks another way: where no place looks like another, three descriptors that differ say little.
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
  out.contributions[verdict_term_count + 7] = {"hardly any path is shared", hardly_any_path(e)};
  out.contributions[verdict_term_count + 8] = {"descriptors hardly tell it from another place", hardly_told_apart(e)};
  return out;
}

double LogOdds::taken_as_given() const {
  return std::accumulate(contributions.begin() + verdict_term_count, contributions.end() - 2, 0.0,
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
  // What slides freely along the tunnel can look right at many places: at most a candidate.
  return status == RegistrationStatus::converged ? p : 0.4 * p;
}

}  // namespace headframe
