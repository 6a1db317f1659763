#pragma once
// From evidence to a probability: terms whose weights were fitted on labelled placements (tests/bench/fit_verdict.py),
// and terms set by hand where a fit lacks data, such as the overlap demanded of a mine that repeats itself.

#include <array>
#include <string_view>

#include "server/registration/registration.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// One argument for or against a placement, in a unit of its own. Larger is better for the placement, and its weight is
/// never negative.
struct VerdictTerm {
  std::string_view name;
  double value = 0;
};
inline constexpr std::size_t verdict_term_count = 8;
inline constexpr std::size_t verdict_contribution_count = verdict_term_count + 13;
std::array<VerdictTerm, verdict_term_count> verdict_terms(const Evidence& evidence);

/// What each term adds to the log-odds. First the fitted ones, named by verdict_terms(); then those set by hand:
/// missing overlap where the mine repeats itself, shared path, a long overlap whose places all agree, free space
/// farther off, few matching points, places that look alike, tilt, places that lie apart, surfaces that do not match,
/// hardly any shared path, descriptors that hardly distinguish it from another place, walls farther off that match, and
/// how little tells a short overlap from a copy.
struct LogOdds {
  double bias = 0;
  std::array<VerdictTerm, verdict_contribution_count> contributions;
  double taken_as_given() const;  // the part set by hand that the fit takes as an offset
  double without_short_rule() const { return sum() - contributions.back().value; }  // which is fitted on this
  double sum() const;
};
LogOdds log_odds(const Evidence& evidence);

/// Probability that a placement is right; 0 unless its registration converged or is degenerate. Where the mine may hold
/// copies it is far too low, so that none of them is merged: see calibrated().
double probability(RegistrationStatus status, const Evidence& evidence);

/// How often a placement with such a probability and probability_if_unique is right, which is what people are told.
/// From accept_probability on it is the probability itself; what lies below that stays below it. Where nothing but its
/// likeness to other places speaks against a placement (probability_if_unique .97 and more), 23 of 110 below 1e-6 were
/// right, of the others 64 of 87 below .01, and 32 of 40 below .2. They are all told .44 and more, whatever the
/// probability. Fitted by tests/bench/fit_told.py.
double calibrated(const Evidence& evidence, const VerdictThresholds& thresholds);

}  // namespace headframe
