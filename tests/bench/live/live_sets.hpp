#pragma once
// What is driven, and under which conditions.

#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/live/live_run.hpp"

namespace headframe::bench {

/// Sessions that are driven again and again; read or drawn when they are needed.
struct LiveSet {
  std::string name;
  std::string kind;  // of the drawn mine, or "tunnel-four", ...
  std::vector<LiveConditions> conditions;
  std::function<std::vector<DrivenSession>()> driving;
  std::function<std::vector<DrivenSession>()> present = [] { return std::vector<DrivenSession>(); };
};

/// Those of the recordings that are there, and drawn mines with seeds from first_seed on.
std::vector<LiveSet> live_sets(const std::filesystem::path& recordings, std::uint64_t first_seed);

/// Data sets below the folders, each driven twice, with the sessions of the one before it through the same world there
/// already. The robots of a set take the descriptor families in turn.
std::vector<LiveSet> made_live_sets(const std::vector<std::filesystem::path>& folders,
                                    const std::vector<std::string>& families);

/// "6x busy together at once", for tables.
std::string text_of(const LiveConditions& conditions);

}  // namespace headframe::bench
