#pragma once
// What became of live drives, in lines, tables and JSON.

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/live/live_watch.hpp"

namespace headframe::bench {

struct LiveDrive {
  std::string set, kind, conditions;
  std::vector<Stood> wrong, right;
  std::vector<Claim> claims;
  std::size_t right_withdrawn = 0, attempts = 0;
  bool wrong_provisional = false;
  int meet = 0;                             // pairs that truly do
  std::vector<std::string> end_differs;     // from the set's first drive
  std::vector<std::string> asking_changed;  // the operator's `merge` at the end
};

void print(const LiveDrive& drive);
nlohmann::json to_json(const LiveDrive& drive);

/// Path of both sessions when each right merge came that stood at the end, by drive and pair.
using RightMerges = std::map<std::string, std::pair<double, double>>;
/// Of a live-drives.jsonl that another version wrote; none where there is no file.
RightMerges read_right_merges(const std::filesystem::path& lines);

/// The table by kind, and the fields of the bars.
nlohmann::json summary(const std::vector<LiveDrive>& drives, const RightMerges& before);

}  // namespace headframe::bench
