#include "tests/bench/made_sets.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "common/descriptor/family.hpp"

namespace headframe::bench {
namespace {

std::unique_ptr<DescriptorFamily> family_named(const std::string& name) {
  auto family = make_family(name);
  if (!family) throw std::runtime_error(family.error().message);
  return std::move(*family);
}

}  // namespace

std::vector<std::filesystem::path> sets_below(const std::vector<std::filesystem::path>& folders) {
  std::vector<std::filesystem::path> sets;
  for (const auto& folder : folders) {
    if (exists(folder / "truth.json")) {
      sets.push_back(folder);
      continue;
    }
    if (!is_directory(folder)) throw std::runtime_error("no such folder: " + folder.string());
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (exists(entry.path() / "truth.json")) sets.push_back(entry.path());
  }
  std::sort(sets.begin(), sets.end());
  if (sets.empty()) throw std::runtime_error("no data set (a folder with truth.json) in the folders that were named");
  return sets;
}

nlohmann::json truth_of(const std::filesystem::path& set) {
  std::ifstream in(set / "truth.json");
  try {
    return nlohmann::json::parse(in);
  } catch (const nlohmann::json::parse_error& e) {
    throw std::runtime_error((set / "truth.json").string() + ": no whole JSON (byte " + std::to_string(e.byte) +
                             "); make the data set anew");
  }
}

std::map<std::string, DrivenSession> sessions_of(const std::filesystem::path& set,
                                                 const std::vector<std::string>& families, double days_apart) {
  constexpr double some_day_s = 1.7e9, day_s = 86400;
  std::map<std::string, DrivenSession> sessions;
  const auto truth = truth_of(set);
  for (const auto& [robot, unused] : truth.at("robots").items())
    sessions.emplace(robot,
                     read_driven_session(set, robot, *family_named(families[sessions.size() % families.size()])));
  double first_s = some_day_s;
  for (auto& [robot, session] : sessions) {
    if (days_apart == 0) break;
    for (Keyframe& keyframe : session.keyframes) keyframe.stamp_s += first_s;
    first_s += days_apart * day_s;
  }
  return sessions;
}

std::string kind_of(const std::string& set) { return set.substr(0, set.find('-')); }

}  // namespace headframe::bench
