#pragma once
// From evidence to a probability: terms with weights fitted on labelled placements (tests/bench/fit_verdict.py), and
// what is set by hand because no fit can know it: how much overlap a mine that repeats itself is asked for.

#include <array>
#include <string_view>

#include "server/registration/registration.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// One thing that speaks for a placement or against it, in units of its own. More is better for the placement, and its
/// weight is never negative.
struct VerdictTerm {
  std::string_view name;
  double value = 0;
};
inline constexpr std::size_t verdict_term_count = 8;
inline constexpr std::size_t verdict_contribution_count = verdict_term_count + 9;
std::array<VerdictTerm, verdict_term_count> verdict_terms(const Evidence& evidence);

/// What each term adds to the log-odds, as named by verdict_terms(), and what was set by hand: that places look alike,
/// the overlap that is missing where the mine repeats itself, how much path is shared, a long overlap whose places all
/// agree, what lies farther off, how few points meet, how far it leans, and whether descriptors tell it from what looks
/// alike.
struct LogOdds {
  double bias = 0;
  std::array<VerdictTerm, verdict_contribution_count> contributions;
  double taken_as_given() const;  // by the fit, of the sum: set by hand
  double sum() const;
};
LogOdds log_odds(const Evidence& evidence);

/// Probability that a placement is right; 0 unless its registration converged or is degenerate.
double probability(RegistrationStatus status, const Evidence& evidence);

}  // namespace headframe
