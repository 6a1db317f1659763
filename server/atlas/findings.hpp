#pragma once
// What the verdict was made of, in words: one finding for each term that was weighed, and none for what was not.

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
};

/// Those that speak against the placement first, the strongest first.
std::vector<Finding> findings_of(const Evidence& evidence);

/// The probability if the term spoke neither way.
double probability_without(const Finding& finding, const Evidence& evidence);

}  // namespace headframe
