#include "server/net/robot_quota.hpp"

namespace headframe {
namespace {

constexpr auto day = std::chrono::hours(24);

}  // namespace

std::string RobotQuota::objection(const std::string& robot, int connected, bool is_new, Time now) const {
  if (connected >= limits_.sessions)
    return "robot " + robot + " has " + std::to_string(connected) +
           " sessions connected, as many as limits.sessions allows; try again later";
  const auto begun = begun_.find(robot);
  if (!is_new || begun == begun_.end()) return "";
  const auto most = static_cast<std::size_t>(limits_.sessions_a_day);
  if (begun->second.size() < most || now - begun->second.front() >= day) return "";
  return "robot " + robot + " has begun " + std::to_string(most) +
         " sessions within a day, as many as limits.sessions_a_day allows; try again later";
}

void RobotQuota::began_session(const std::string& robot, Time now) {
  auto& begun = begun_[robot];
  begun.push_back(now);
  if (begun.size() > static_cast<std::size_t>(limits_.sessions_a_day)) begun.pop_front();
}

}  // namespace headframe
