#include "tests/mine/demo/outcome.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "tests/mine/demo/demo_mine.hpp"
#include "tests/support/truth.hpp"

namespace headframe::demo {
namespace {

using Json = nlohmann::json;

const Json* find(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto at = object.find(key);
  return at == object.end() || at->is_null() ? nullptr : &*at;
}

std::string text(const Json& object, const char* key) {
  const Json* value = find(object, key);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

double number(const Json& object, const char* key, double otherwise) {
  const Json* value = find(object, key);
  return value != nullptr && value->is_number() ? value->get<double>() : otherwise;
}

Pose pose(const Json& numbers) {
  Pose T = Pose::Identity();
  if (!numbers.is_array() || numbers.size() != 16) return T;
  for (int i = 0; i < 16; ++i) T.matrix()(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)].get<double>();
  return T;
}

void read_session(RobotOutcome& robot, const Json& row) {
  robot.keyframes = static_cast<std::uint64_t>(number(row, "keyframes", 0));
  robot.bytes_sent = static_cast<std::uint64_t>(number(row, "bytes_received", 0));
  if (find(row, "trigger_to_transform_ms") != nullptr)
    robot.trigger_to_transform_ms = number(row, "trigger_to_transform_ms", 0);
}

void read_atlas(std::vector<RobotOutcome>& robots, const Json& atlas) {
  const Json* components = find(atlas, "components");
  if (components == nullptr) return;
  for (const Json& component : *components) {
    const Json* placed = find(component, "sessions");
    for (const Json& session : placed != nullptr ? *placed : Json::array())
      for (RobotOutcome& robot : robots) {
        if (robot.name != text(session, "robot")) continue;
        robot.component = static_cast<std::uint64_t>(number(component, "id", 0));
        if (const Json* T = find(session, "T_component_session")) robot.T_component_session = pose(*T);
      }
  }
}

void add_errors(std::vector<RobotOutcome>& robots, const std::filesystem::path& recordings) {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const auto path_a = test::read_true_path(recordings, robots[i].name);
    for (std::size_t k = i + 1; k < robots.size(); ++k) {
      if (!robots[i].component || robots[i].component != robots[k].component) continue;
      const Pose T_a_b = robots[i].T_component_session.inverse() * robots[k].T_component_session;
      const auto error = test::overlap_error(path_a, test::read_true_path(recordings, robots[k].name), T_a_b);
      if (error.pairs == 0) continue;
      for (RobotOutcome* robot : {&robots[i], &robots[k]}) {
        robot->error_m = std::max(robot->error_m, error.translation_m);
        robot->error_deg = std::max(robot->error_deg, error.rotation_deg);
      }
    }
  }
}

std::size_t members(const std::vector<RobotOutcome>& robots, std::uint64_t component) {
  return static_cast<std::size_t>(std::count_if(
      robots.begin(), robots.end(), [&](const RobotOutcome& robot) { return robot.component == component; }));
}

}  // namespace

std::vector<RobotOutcome> outcome_of(const Json& sessions, const Json& atlas, const std::filesystem::path& recordings) {
  std::vector<RobotOutcome> robots;
  for (const DemoRobot& known : demo_robots()) robots.push_back({.name = known.name, .sensor = known.sensor});
  if (const Json* rows = find(sessions, "sessions"))
    for (const Json& row : *rows)
      for (RobotOutcome& robot : robots)
        if (robot.name == text(row, "robot")) read_session(robot, row);
  read_atlas(robots, atlas);
  if (!recordings.empty()) add_errors(robots, recordings);
  return robots;
}

std::optional<std::uint64_t> largest_component(const std::vector<RobotOutcome>& robots) {
  std::optional<std::uint64_t> best;
  for (const RobotOutcome& robot : robots)
    if (robot.component && (!best || members(robots, *robot.component) > members(robots, *best)))
      best = robot.component;
  return best;
}

std::size_t count_together(const std::vector<RobotOutcome>& robots) {
  const auto component = largest_component(robots);
  return component ? members(robots, *component) : 0;
}

bool merged_rightly(const std::vector<RobotOutcome>& robots) {
  return !robots.empty() && std::all_of(robots.begin(), robots.end(), [&](const RobotOutcome& robot) {
    return robot.component && robot.component == robots.front().component && robot.error_m >= 0 &&
           robot.error_m <= 0.3 && robot.error_deg >= 0 && robot.error_deg <= 1.0;
  });
}

std::string table_of(const std::vector<RobotOutcome>& robots) {
  std::string table =
      "  robot    sensor       keyframes      x m      y m      z m    yaw deg   error m  error deg"
      "  transform after  sent\n";
  for (const RobotOutcome& robot : robots) {
    char line[256];
    const Eigen::Vector3d t = robot.T_component_session.translation();
    const double yaw_deg = yaw_rad(robot.T_component_session) * 180 / std::numbers::pi;
    char place[64] = "       -        -        -          -";  // alone in its frame
    if (robot.component && members(robots, *robot.component) > 1)
      std::snprintf(place, sizeof place, "%8.2f %8.2f %8.2f %10.2f", t.x(), t.y(), t.z(), yaw_deg);
    char after[32] = "-";
    if (robot.trigger_to_transform_ms)
      std::snprintf(after, sizeof after, "%.2f s", *robot.trigger_to_transform_ms / 1000);
    char error[48] = "       -          -";
    if (robot.error_m >= 0) std::snprintf(error, sizeof error, "%8.3f   %8.2f", robot.error_m, robot.error_deg);
    std::snprintf(line, sizeof line, "  %-8s %-12s %9llu %s  %s  %15s  %.1f MB\n", robot.name.c_str(),
                  robot.sensor.c_str(), static_cast<unsigned long long>(robot.keyframes), place, error, after,
                  static_cast<double>(robot.bytes_sent) / 1e6);
    table += line;
  }
  return table;
}

}  // namespace headframe::demo
