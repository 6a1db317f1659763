#pragma once
// From evidence to a probability: each term is one measure and a curve of log-odds over it, and the verdict is their
// sum. The curves are fitted on labelled placements (tests/bench/fit_verdict.py) and can only fall towards the worse
// side of a measure.

#include <array>
#include <string_view>

#include "server/registration/registration.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// One argument for or against a placement.
struct VerdictTerm {
  std::string_view name;
  double value = 0;
};
inline constexpr std::size_t verdict_term_count = 16;

/// What each term measures, in the unit over which its curve is drawn. NaN: nothing is known, which says nothing.
std::array<VerdictTerm, verdict_term_count> verdict_measures(const Evidence& evidence);

/// What each term adds to the log-odds: 0 at the median of right placements, less where the measure is worse.
struct LogOdds {
  double bias = 0;  // of a placement that is right and usual in everything
  std::array<VerdictTerm, verdict_term_count> contributions;
  double sum() const;
};
LogOdds log_odds(const Evidence& evidence);

/// Most tilt between two maps, which are both level; no right placement had more.
inline constexpr double most_tilt_deg = 3;

/// Probability that a placement is right; 0 unless its registration converged or is degenerate. In the fit a wrong
/// placement weighs more than a right one, because a wrong merge costs more: see calibrated().
double probability(RegistrationStatus status, const Evidence& evidence);

/// How often a placement with such a probability is right, which is what people are told: the odds without the weight
/// that wrong placements have in the fit. From accept_probability on it is the probability itself; what lies below
/// that stays below it.
double calibrated(const Evidence& evidence, const VerdictThresholds& thresholds);

}  // namespace headframe
