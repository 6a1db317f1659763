#include "server/net/robot_quota.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr auto day = std::chrono::hours(24);

}  // namespace

std::string RobotQuota::objection(const std::string& robot, int connected, bool is_new, Time now) const {
  if (connected >= limits_.sessions)
    return "robot " + robot + " has " + std::to_string(connected) +
           " sessions connected, as many as limits.sessions allows; try again later";
  Allowance next = left(robot, now);
  next.keyframes -= 1;
  if (auto why = used_up(robot, next); !why.empty()) return why;
  const auto begun = begun_.find(robot);
  if (!is_new || begun == begun_.end()) return "";
  const auto most = static_cast<std::size_t>(limits_.sessions_a_day);
  if (begun->second.size() < most || now - begun->second.front() >= day) return "";
  return "robot " + robot + " has begun " + std::to_string(most) +
         " sessions within a day, as many as limits.sessions_a_day allows; try again later";
}

RobotQuota::Allowance RobotQuota::left(const std::string& robot, Time now) const {
  const Allowance most{static_cast<double>(limits_.keyframes_a_day), limits_.stored_mib_a_day * 1024.0 * 1024.0, now};
  const auto known = allowances_.find(robot);
  if (known == allowances_.end()) return most;
  const Allowance& before = known->second;
  const double days = std::chrono::duration<double>(now - before.at) / std::chrono::duration<double>(day);
  return {std::min(most.keyframes, before.keyframes + days * most.keyframes),
          std::min(most.bytes, before.bytes + days * most.bytes), now};
}

std::string RobotQuota::used_up(const std::string& robot, const Allowance& left) const {
  if (left.keyframes < 0)
    return "robot " + robot + " has sent " + std::to_string(limits_.keyframes_a_day) +
           " keyframes within a day, as many as limits.keyframes_a_day allows; try again later";
  if (left.bytes < 0)
    return "robot " + robot + " has sent " + std::to_string(limits_.stored_mib_a_day) +
           " MiB within a day, as many as limits.stored_mib_a_day allows; try again later";
  return "";
}

std::string RobotQuota::stores(const std::string& robot, int keyframes, std::size_t bytes, Time now) {
  Allowance allowance = left(robot, now);
  allowance.keyframes -= keyframes;
  allowance.bytes -= static_cast<double>(bytes);
  if (auto why = used_up(robot, allowance); !why.empty()) return why;
  allowances_[robot] = allowance;
  return "";
}

void RobotQuota::began_session(const std::string& robot, Time now) {
  auto& begun = begun_[robot];
  begun.push_back(now);
  if (begun.size() > static_cast<std::size_t>(limits_.sessions_a_day)) begun.pop_front();
}

}  // namespace headframe
