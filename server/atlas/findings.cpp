#include "server/atlas/findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/atlas/formatted.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

constexpr double next_to_nothing = 0.25;  // log-odds
constexpr std::size_t always_said = 5;    // of the terms; the others only where they apply

std::string descriptors(const Evidence& e) {
  if (e.descriptors_compared == 0)
    return "no keyframe stands within 3 m of one of the other's: descriptors say nothing";
  return formatted("%.0f keyframes stand where one of the other's stood; what they describe is %.0f %% alike",
                   e.descriptors_compared, 100 * e.descriptors_alike);
}

std::string hold(const Evidence& e) {
  if (e.weakest_hold >= held_well) return "the walls hold the position in every direction";
  return formatted(
      "the walls hardly hold the position along the tunnel, and of the surfaces that face along it %.0f %% meet",
      100 * e.end_on_match);
}

std::string places(const Evidence& e) {
  return formatted("%.0f of %.0f places along the overlap, registered each by itself, agree; they would move by %.2f m",
                   e.places_agreeing, e.places, e.spread_m);
}

std::string copies(const Evidence& e) {
  const double asked_m = std::max(asked_overlap_m(e), asked_among_look_alikes_m(e));
  if (asked_m <= 0) return "the mine is not known to repeat itself";
  return formatted(
      "the mine repeats itself (at %.1f other placements a place looks the same and %.0f of them pass every test; %.1f "
      "copies in 100 m of all that is known): %.0f m shared, %.0f m would tell",
      e.look_alikes, e.aliases, e.repetition, e.overlap_m, asked_m);
}

std::string shared(const Evidence& e) { return formatted("%.0f m of path are shared", e.overlap_m); }

/// What a contribution means, in the order of LogOdds::contributions.
std::array<std::string, verdict_contribution_count> words_of(const Evidence& e) {
  return {
      {formatted("%.2f %% of the points lie where the other's rays passed through", 100 * e.freespace_violation),
       formatted("%.2f %% do so at the place that contradicts most", 100 * e.worst_place_violation),
       formatted("the surfaces lie %.0f mm apart", 1000 * e.residual_m), places(e), hold(e), descriptors(e),
       descriptors(e), copies(e), shared(e), places(e),
       formatted("%.2f %% of the points do so up to 25 m away at one place: a copy would end there",
                 100 * e.farther_violation),
       formatted("only %.0f %% of the points where they meet have a partner in the other map", 100 * e.inlier_fraction),
       shared(e) + ": hardly any"}};
}

}  // namespace

std::string_view to_string(Speaks speaks) { return speaks == Speaks::against ? "against" : "for"; }

std::vector<Finding> findings_of(const Evidence& evidence) {
  const LogOdds odds = log_odds(evidence);
  const auto words = words_of(evidence);
  std::vector<Finding> out;
  for (std::size_t i = 0; i < odds.contributions.size(); ++i) {
    const auto& [name, value] = odds.contributions[i];
    if (i >= always_said && value == 0) continue;
    out.push_back({name, value, value < -next_to_nothing ? Speaks::against : Speaks::in_favour, words[i]});
  }
  std::stable_sort(out.begin(), out.end(), [](const Finding& f, const Finding& g) {
    if (f.speaks != g.speaks) return f.speaks == Speaks::against;
    return f.speaks == Speaks::against ? f.log_odds < g.log_odds : f.log_odds > g.log_odds;
  });
  return out;
}

double probability_without(const Finding& finding, const Evidence& evidence) {
  return 1 / (1 + std::exp(finding.log_odds - log_odds(evidence).sum()));
}

}  // namespace headframe
