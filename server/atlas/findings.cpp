#include "server/atlas/findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/atlas/formatted.hpp"
#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

constexpr double next_to_nothing = 0.25;  // log-odds

std::string descriptors(const Evidence& e) {
  if (e.descriptors_compared == 0)
    return "no two keyframes of one known descriptor family stand within 3 m of each other: descriptors say nothing";
  return formatted("%.0f keyframes stand where one of the other's stood; what they describe is %.0f %% alike",
                   e.descriptors_compared, 100 * e.descriptors_alike);
}

std::string copies(const Evidence& e) {
  return formatted("%.1f other placements pass every test; all sessions show %.2f copies in 100 m", e.aliases,
                   e.repetition);
}

std::string look_alikes(const Evidence& e) {
  return formatted("at %.1f other placements a place, taken alone, looks the same; %.2f are to be expected in 100 m",
                   e.look_alikes, e.mine_look_alikes);
}

std::string similar_places(const Evidence& e) {
  if (e.mine_similar_places < 0) return "whether other places are similar is not known";
  return formatted("at %.1f other placements a place is similar; %.2f are to be expected in 100 m", e.similar_places,
                   e.mine_similar_places);
}

/// Without what changes of the mine explain, which does not count.
std::string violation(const Evidence& e) {
  std::string out = formatted(
      "%.2f %% of the points lie where the other's rays passed through, at the place that "
      "contradicts most",
      100 * worst_place_contradiction(e));
  const double excused = excused_by_changes(e) * e.worst_place_explained;
  return excused > 0 ? out + formatted(", besides %.2f %% where the mine has changed", 100 * excused) : out;
}

std::string farther_violation(const Evidence& e) {
  return formatted("%.2f %% of the points do so up to 25 m away at one place: a copy would end there",
                   100 * farther_contradiction(e));
}

std::string scatter(const Evidence& e) {
  const std::string out = formatted("points lie %.0f mm off the surfaces, root mean square", 1000 * e.rmse_m);
  if (!(e.own_scatter_m > 0)) return out + "; how rough the rock is was not measured";
  return out + formatted(", and %.0f mm off those of their own session", 1000 * e.own_scatter_m);
}

std::string walls(const Evidence& e) {
  if (!(e.support > 0)) return "the placement came from no search of the walls";
  return formatted("the walls of both sessions, also far from the paths, match with a score of %.0f over %.0f m",
                   e.support, e.overlap_m);
}

std::string rock(const Evidence& e) {
  if (e.rock_in_common <= hardly_any_rock) return "how much rock both saw is not known";
  return formatted("both saw the rock in %.0f cubes of a metre, %.0f for each metre of tunnel looked at",
                   e.rock_in_common, rock_per_metre(e));
}

/// What a contribution means, in the order of verdict_measures().
std::array<std::string, verdict_term_count> words_of(const Evidence& e) {
  return {{formatted("%.0f m of path are shared", e.overlap_m), violation(e), farther_violation(e), scatter(e),
           formatted("places along the overlap, registered each by itself, would move by %.2f m", e.spread_m),
           formatted("%.0f of %.0f places along the overlap agree", e.places_agreeing, e.places), copies(e),
           look_alikes(e), similar_places(e),
           formatted("the walls hold the position along the tunnel by %.3f", e.weakest_hold),
           formatted("of the surfaces that face along the tunnel %.0f %% meet", 100 * e.end_on_match), descriptors(e),
           descriptors(e) + formatted(", over %.0f m", e.overlap_m),
           formatted("the maps would lean by %.2f deg against each other", e.tilt_deg), walls(e), rock(e)}};
}

/// The evidence that determines a contribution, and how to word it.
struct Driver {
  double Evidence::*member = nullptr;
  double best = 0;
  const char* words = "";  // wording, with the scaled value
  double scale = 1;
};

/// In the order of verdict_measures().
std::array<Driver, verdict_term_count> drivers_of(const Evidence& e) {
  constexpr const char* points = "%.3f %% at most would suffice";
  const Driver alike{&Evidence::descriptors_alike, 1, "%.0f %% alike would suffice", 100};
  return {{{&Evidence::overlap_m, 200, "%.0f m of path in common would suffice"},
           {&Evidence::worst_place_violation, 0, points, 100},
           {&Evidence::farther_violation, 0, points, 100},
           {&Evidence::rmse_m, 0, "%.0f mm at most would suffice", 1000},
           {&Evidence::spread_m, 0, "%.2f m at most would suffice"},
           {&Evidence::places_agreeing, e.places, "%.1f places that agree would suffice"},
           {&Evidence::aliases, 0, "%.1f at most would suffice"},
           {&Evidence::look_alikes, 0, "%.1f look-alikes at most would suffice"},
           {&Evidence::mine_similar_places, 0, "%.2f in 100 m at most would suffice"},
           {&Evidence::weakest_hold, 1. / 3, "a hold of %.3f would suffice"},
           {&Evidence::end_on_match, 1, "%.0f %% would suffice", 100},
           alike,
           alike,
           {&Evidence::tilt_deg, 0, "%.2f deg at most would suffice"},
           {&Evidence::support, 5000, "a score of %.0f would suffice"},
           {&Evidence::rock_in_common, 10000, "%.0f would suffice"}}};
}

/// The value that would suffice with everything else unchanged: the nearest to the measured one. Nullopt if not even
/// the best value would.
std::optional<double> sufficient(const Driver& driver, Evidence e, double accept_probability) {
  const double asked = std::log(accept_probability / (1 - accept_probability));
  const auto believed = [&](double value) {
    e.*driver.member = value;
    return log_odds(e).sum() >= asked;
  };
  double little = e.*driver.member, enough = driver.best;
  if (believed(little) || !believed(enough)) return std::nullopt;
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = (little + enough) / 2;
    (believed(middle) ? enough : little) = middle;
  }
  return enough;
}

/// The evidence without what changes excuse, so that a value can be varied.
Evidence as_weighed(Evidence e) {
  e.freespace_violation = freespace_contradiction(e);
  e.worst_place_violation = worst_place_contradiction(e);
  e.farther_violation = farther_contradiction(e);
  e.freespace_explained = e.worst_place_explained = e.farther_explained = 0;
  return e;
}

}  // namespace

std::string_view to_string(Speaks speaks) { return speaks == Speaks::against ? "against" : "for"; }

std::vector<Finding> findings_of(const Evidence& evidence, const VerdictThresholds& thresholds) {
  const LogOdds odds = log_odds(evidence);
  const auto words = words_of(evidence);
  const auto drivers = drivers_of(evidence);
  std::vector<Finding> out;
  for (std::size_t i = 0; i < odds.contributions.size(); ++i) {
    const auto& [name, value] = odds.contributions[i];
    Finding finding{name, value, value < -next_to_nothing ? Speaks::against : Speaks::in_favour, words[i]};
    if (finding.speaks == Speaks::against)
      finding.sufficient = sufficient(drivers[i], as_weighed(evidence), thresholds.accept_probability);
    if (finding.sufficient) finding.would_suffice = formatted(drivers[i].words, drivers[i].scale * *finding.sufficient);
    out.push_back(std::move(finding));
  }
  std::stable_sort(out.begin(), out.end(), [](const Finding& f, const Finding& g) {
    if (f.speaks != g.speaks) return f.speaks == Speaks::against;
    return f.speaks == Speaks::against ? f.log_odds < g.log_odds : f.log_odds > g.log_odds;
  });
  return out;
}

double probability_without(const Finding& finding, const Evidence& evidence, const VerdictThresholds& thresholds) {
  Evidence without = evidence;
  without.probability = 1 / (1 + std::exp(finding.log_odds - log_odds(evidence).sum()));
  return calibrated(without, thresholds);
}

std::vector<Gate> gates_of(const Alignment& alignment, const VerdictThresholds& thresholds) {
  const Evidence& e = alignment.evidence;
  const double weighed = 1 / (1 + std::exp(-log_odds(e).sum()));
  const bool upright = !(e.tilt_deg > most_tilt_deg);
  // With a degenerate registration, or a tilt, the probability is lower than the terms say.
  const bool held = !upright || !(e.probability < 0.99 * weighed);
  return {
      {"upright", upright, formatted("gravity agrees to within %.1f deg of %.0f", e.tilt_deg, most_tilt_deg)},
      {"held", held,
       held ? "the rock holds the placement in every direction"
            : "it slides freely along the tunnel: of the probability 40 % are left"},
      {"probable", e.probability >= thresholds.accept_probability,
       formatted("the probability is %.3f of %.2f", e.probability, thresholds.accept_probability)},
      {"told from its runner-up", runner_up_share(e) < thresholds.runner_up_share,
       formatted("the runner-up's odds count as %.3f of this one's, below %.2f is asked for", runner_up_share(e),
                 thresholds.runner_up_share)},
      {"path that is awaited", !(e.awaited_m > 0), formatted("%.0f m more are waited for", e.awaited_m)},
      {"other sessions", !alignment.objection,
       alignment.objection
           ? formatted("two that would lie on each other contradict each other with %.1f %% of the points",
                       100 * alignment.objection->violation)
           : "none is known to contradict it"},
  };
}

}  // namespace headframe
