#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace headframe::bench {

struct CoverageBench {
  std::filesystem::path recordings = "../shared/data";
  double mine_km = 10;
  std::uint64_t first_seed = 300000;
};

/// How many bytes tell a robot what others have seen: all of a mine of so many kilometres, drawn drives through rock of
/// their own side by side; and what is new after each 50 m of one of them. The same for every recorded drive that is
/// there, one mine of them all.
nlohmann::json coverage(const CoverageBench& bench);

}  // namespace headframe::bench
