#include "server/verification/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "server/verification/ramp.hpp"
#include "server/verification/verdict_curves.hpp"

namespace headframe {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Shares of points range over decades; below `least` they are noise.
double decades(double share, double least) { return std::log10(std::max(share, 0.0) + least); }

/// As if three more keyframes had been compared, with the similarity of a usual place.
double cautious_similarity(const Evidence& e) {
  constexpr double more = 3, usual = 0.8;
  return (e.descriptors_compared * e.descriptors_alike + more * usual) / (e.descriptors_compared + more);
}

/// Aliases; or, if all sessions together show many copies, as many as are to be reckoned with where the pair shows
/// none: the copy that would be merged wrongly need not have been driven through twice.
double copies(const Evidence& e) {
  constexpr double few = 0.3, many = 0.5;  // per 100 m; .58 to 1.6 in drawn mines of copies, up to .24 in recordings
  return std::max(e.aliases, std::clamp((e.repetition - few) / (many - few), 0.0, 2.0));
}

/// How far the descriptors are nearly equal, 0 to 1 (fully from .95 on over four keyframes, not up to .90). Then they
/// tell a place from those that look like it to the walls, and where it is along a straight tunnel: right placements
/// over some 30 m of one agree to .95 and .97. But what is copied is described alike: where copies are known, or 1.4
/// look-alikes are to be expected in 100 m (not up to 1.25), twelve keyframes have to agree (eight tell nothing).
/// Copies over 27 and 37 m of such mines agreed to .96 and .97 at seven and nine; of 34 placements beside look-alikes
/// with .92 and more at twelve, one was wrong.
double descriptors_tell(const Evidence& e) {
  const double unique =
      std::min(ramp(e.repetition, copies_known, copies_known / 2), ramp(e.mine_look_alikes, 1.4, 1.25));
  const double enough = std::max(unique, ramp(e.descriptors_compared, 8, 12));
  return ramp(e.descriptors_alike, 0.9, 0.95) * std::min({1.0, e.descriptors_compared / 4, enough});
}

/// Look-alikes of the pair, or what is to be expected of 300 m of this mine (200 to 400 m fit alike); those that
/// descriptors do not tell apart.
double like_places(const Evidence& e) {
  return (1 - descriptors_tell(e)) * std::max(e.look_alikes, 3 * e.mine_look_alikes);
}

/// A mine of which no place is similar to another holds no copies either, so less has to speak for a placement.
double similar(const Evidence& e) { return e.mine_similar_places >= 0 ? e.mine_similar_places : unknown; }

/// Descriptors that are nearly equal hold it as if it were no straight tunnel (those hold by less than .05).
double hold(const Evidence& e) { return std::max(e.weakest_hold, 0.05 * descriptors_tell(e)); }

/// Of five keyframes and more (not of up to three) that agree to .72 and less (not from .76 on) over 40 m and less (not
/// from 50 on); over 25 m and less (less so up to 32) to .78 and less (not from .82 on). Whatever looks alike: in live
/// drives, of which little was known yet, copies of 34 to 40 m of a cave of tiles had .66 to .72, and a crosscut of a
/// smooth tunnel over 23 m, .78.
double differ_over_little_path(const Evidence& e) {
  const double stricter = 0.06 * ramp(e.overlap_m, 32, 25);
  return ramp(e.descriptors_compared, 3, 5) * ramp(e.overlap_m, 50, 40) *
         ramp(e.descriptors_alike, 0.76 + stricter, 0.72 + stricter);
}

/// Half-metre cells of wall that match, per metre of shared path: a copy of a few tiles matches less far to its sides.
/// Over little path (10 m and less; not from 14 m on), those of a straight tunnel (that hold it by .03 and less; not
/// from .05 on) do not count, because they match in any such tunnel: one placement over 5 m was 57 m off. Not known if
/// the placement came from no search.
double walls_per_metre(const Evidence& e) {
  constexpr double least_m = 10;
  if (!(e.support > 0)) return unknown;
  const double of_any_tunnel = ramp(e.overlap_m, 14, least_m) * ramp(hold(e), 0.05, 0.03);
  return (1 - of_any_tunnel) * e.support / std::max(e.overlap_m, least_m);
}

/// How much farther the points of each session lie off the other's surfaces than off its own: rough rock scatters in
/// any mine, also where the placement is right. Not known of evidence from before this was measured.
double scatter(const Evidence& e) { return e.own_scatter_m > 0 ? e.rmse_m / e.own_scatter_m : unknown; }

/// Halls, crossings and side walls that both saw, whatever path they share. A wrong placement is not contradicted by
/// rock that neither saw; and a copy of a drift over 50 m shows as much rock as a right placement at a junction, but
/// not as much per metre. Not known if it was not looked at.
double rock(const Evidence& e) { return e.rock_in_common > 0 ? std::log2(rock_per_metre(e)) : unknown; }

/// The curve at x: linear between its knots, level outside them.
double at(std::span<const VerdictKnot> curve, double x) {
  const auto next = std::upper_bound(curve.begin(), curve.end(), x,
                                     [](double value, const VerdictKnot& knot) { return value < knot.at; });
  if (next == curve.begin()) return curve.front().log_odds;
  if (next == curve.end()) return curve.back().log_odds;
  const VerdictKnot &from = *std::prev(next), &to = *next;
  return std::lerp(from.log_odds, to.log_odds, (x - from.at) / (to.at - from.at));
}

}  // namespace

std::array<VerdictTerm, verdict_term_count> verdict_measures(const Evidence& e) {
  return {{
      {"path that is shared", std::log2(std::max(e.overlap_m, 1.0))},
      {"free space contradicts", decades(worst_place_contradiction(e), 1e-4)},
      {"free space farther off contradicts", decades(farther_contradiction(e), 3e-4)},
      {"points scatter about the surfaces", scatter(e)},
      {"places lie apart", e.spread_m},
      {"places disagree", 1 - e.places_agreeing / std::max(1.0, e.places)},
      {"the mine repeats itself", copies(e)},
      {"places look alike", std::log2(1 + like_places(e))},
      {"places are similar", similar(e)},
      {"walls hold it", hold(e)},
      {"surfaces across the tunnel match", e.end_on_match},
      {"descriptors agree", cautious_similarity(e)},
      {"descriptors differ over little path", differ_over_little_path(e)},
      {"gravity disagrees", e.tilt_deg},
      {"walls match", walls_per_metre(e)},
      {"rock that both saw", rock(e)},
  }};
}

LogOdds log_odds(const Evidence& e) {
  LogOdds out{verdict_bias, verdict_measures(e)};
  for (std::size_t i = 0; i < verdict_term_count; ++i) {
    double& value = out.contributions[i].value;
    value = std::isnan(value) ? 0 : at(verdict_curves[i], value);
  }
  return out;
}

double LogOdds::sum() const {
  return std::accumulate(contributions.begin(), contributions.end(), bias,
                         [](double sum, const VerdictTerm& t) { return sum + t.value; });
}

double probability(RegistrationStatus status, const Evidence& e) {
  if (status == RegistrationStatus::too_little_overlap) return 0;
  if (e.tilt_deg > most_tilt_deg) return 0;
  const double p = 1 / (1 + std::exp(-log_odds(e).sum()));
  // A placement that slides along the tunnel can look right at many places: at most a candidate.
  return status == RegistrationStatus::converged ? p : 0.4 * p;
}

double calibrated(const Evidence& e, const VerdictThresholds& thresholds) {
  if (e.probability >= thresholds.accept_probability) return e.probability;
  const double told = verdict_wrong_weight * odds(e.probability);
  return std::min(told / (1 + told), 0.999 * thresholds.accept_probability);
}

}  // namespace headframe
