#pragma once
// Data sets of drives through worlds, with the truth beside: folders with truth.json and truth/ROBOT.txt.

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/driven_session.hpp"

namespace headframe::bench {

/// The data sets that were named, and those in the folders that were; sorted. Throws where there is none.
std::vector<std::filesystem::path> sets_below(const std::vector<std::filesystem::path>& folders);

nlohmann::json truth_of(const std::filesystem::path& set);

/// By robot. The robots take the families in turn. With days_apart, each drives so many days after the one before, by
/// the stamps of its keyframes; else they are as they were recorded. Throws when one can not be read.
std::map<std::string, DrivenSession> sessions_of(const std::filesystem::path& set,
                                                 const std::vector<std::string>& families, double days_apart = 0);

/// The world that a data set's drives lead through: its name up to the first hyphen.
std::string kind_of(const std::string& set);

}  // namespace headframe::bench
