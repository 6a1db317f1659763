#pragma once
// What the verdict was made of, in words: one finding for each term that was weighed, and none for what was not.

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
  double log_odds = 0;        // that it adds
  Speaks speaks = Speaks::in_favour;
  std::string text;
  std::optional<double> sufficient = std::nullopt;  // of what it measures, to make the placement believed, alone
  std::string would_suffice = {};                   // the same in words; empty: it would not be enough, or it is
};

/// Those that speak against the placement first, the strongest first.
std::vector<Finding> findings_of(const Evidence& evidence, const VerdictThresholds& thresholds = {});

/// What has to be met whatever else speaks for a placement.
struct Gate {
  std::string_view name;
  bool passed = true;
  std::string text;
};

/// All of them, in the order in which they are asked.
std::vector<Gate> gates_of(const Alignment& alignment, const VerdictThresholds& thresholds);

/// The probability if the term spoke neither way.
double probability_without(const Finding& finding, const Evidence& evidence);

}  // namespace headframe
