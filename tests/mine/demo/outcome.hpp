#pragma once
// What came out of the demo: the server's answers, and how near they are to the truth.

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/se3.hpp"

namespace headframe::demo {

struct RobotOutcome {
  std::string name;
  std::string sensor;
  std::uint64_t keyframes = 0;
  std::uint64_t bytes_sent = 0;
  std::optional<double> trigger_to_transform_ms = {};  // none for the robot whose frame is the component's
  std::optional<std::uint64_t> component = {};
  Pose T_component_session = Pose::Identity();
  double error_m = -1;  // the worst of its overlaps with others of its component; -1: none is known
  double error_deg = -1;
};

/// Robots in the demo's order. `sessions` and `atlas` are the API's answers; `recordings` holds the truth. Fields that
/// the server did not give stay at their defaults.
std::vector<RobotOutcome> outcome_of(const nlohmann::json& sessions, const nlohmann::json& atlas,
                                     const std::filesystem::path& recordings);

/// The component that holds the most robots (the first of equals), and how many it holds; none and 0 without answers.
std::optional<std::uint64_t> largest_component(const std::vector<RobotOutcome>& robots);
std::size_t count_together(const std::vector<RobotOutcome>& robots);

/// All robots in one component, each within 0.3 m and 1 deg of the truth where it overlaps others.
bool merged_rightly(const std::vector<RobotOutcome>& robots);

/// A table for people, one line a robot.
std::string table_of(const std::vector<RobotOutcome>& robots);

}  // namespace headframe::demo
