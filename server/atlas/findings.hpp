#pragma once
// The verdict in words: one finding for each term that contributed.

#include <optional>
#include <string>
#include <vector>

#include "server/atlas/alignment.hpp"

namespace headframe {

enum class Speaks { in_favour, against };

std::string_view to_string(Speaks speaks);

/// One term of the verdict.
struct Finding {
  std::string_view evidence;  // the term's name
  double log_odds = 0;        // its contribution
  Speaks speaks = Speaks::in_favour;
  std::string text;
  std::optional<double> sufficient = std::nullopt;  // value of its measure that alone would suffice
  std::string would_suffice = {};                   // the same in words; empty: no value would do, or it is acceptable
};

/// Findings against the placement first, the strongest first.
std::vector<Finding> findings_of(const Evidence& evidence, const VerdictThresholds& thresholds = {});

/// A condition that has to be met whatever else supports a placement.
struct Gate {
  std::string_view name;
  bool passed = true;
  std::string text;
};

/// All gates, in the order in which they are checked.
std::vector<Gate> gates_of(const Alignment& alignment, const VerdictThresholds& thresholds);

/// The probability without this term.
double probability_without(const Finding& finding, const Evidence& evidence, const VerdictThresholds& thresholds);

}  // namespace headframe
