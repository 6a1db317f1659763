#pragma once
// ./run bench one-map: do all drives through a mine become one map?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace headframe::bench {

/// All sessions of each world come to one database, one after another, and are tried in this order. Pairs of sessions
/// whose paths share at least 18 % of the shorter one count as joined when they are in one component. Throws where
/// there is no data set.
nlohmann::json one_map(const std::vector<std::filesystem::path>& folders);

}  // namespace headframe::bench
