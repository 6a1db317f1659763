#pragma once
// What became of live drives, in lines, tables and JSON.

#include <nlohmann/json.hpp>

#include "tests/bench/live/live_watch.hpp"

namespace headframe::bench {

struct LiveDrive {
  std::string set, kind, conditions;
  std::vector<Stood> wrong, right;
  std::vector<Claim> claims;
  std::size_t right_withdrawn = 0, attempts = 0;
  bool wrong_provisional = false;
  std::vector<double> later_m;              // of right merges: path while they waited
  int meet = 0;                             // pairs that truly do
  std::vector<std::string> end_differs;     // from the set's first drive
  std::vector<std::string> asking_changed;  // the operator's `merge` at the end
};

void print(const LiveDrive& drive);
nlohmann::json to_json(const LiveDrive& drive);

/// The table by kind, and the fields of the bars.
nlohmann::json summary(const std::vector<LiveDrive>& drives);

}  // namespace headframe::bench
