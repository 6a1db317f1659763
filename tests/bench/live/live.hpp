#pragma once
// ./run bench live: is anything wrong ever told to a robot, even for a second?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/descriptor/family.hpp"

namespace headframe::bench {

struct LiveBench {
  std::filesystem::path recordings, out;
  std::vector<std::filesystem::path> sets;  // data sets, or folders of them, to drive instead of recordings and mines
  std::vector<std::string> families{
      std::string(default_family_name)};  // the robots of a set in `sets` take them in turn
  std::string only;                       // sets whose names contain it
  std::string conditions;                 // drives whose conditions contain it; ends are compared among those
  std::uint64_t first_seed = 310000;      // of the drawn mines
};

/// Every set of sessions driven under several conditions; all that stood is compared with the truth. Each drive is
/// printed and kept in `out`/live-drives.jsonl as soon as it is done.
nlohmann::json live(const LiveBench& bench);

}  // namespace headframe::bench
