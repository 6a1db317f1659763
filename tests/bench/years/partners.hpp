#pragma once
// ./run bench partners DIR...: is the right session among those that one is tried with?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace headframe::bench {

/// All sessions of the data sets below `folders` in one database. For every two whose paths truly run within 8 m of
/// each other for 10 m and more: how many sessions that share nothing is one tried with before it is tried with the
/// other? Throws when a data set cannot be read.
nlohmann::json partners(const std::vector<std::filesystem::path>& folders);

}  // namespace headframe::bench
