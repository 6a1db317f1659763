#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <string>

#include "server/net/robot_limits.hpp"

namespace headframe {

/// What one robot may take of what all share: so that one that has gone wrong locks out itself and nobody else. Counted
/// since the server started. Not thread safe.
class RobotQuota {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit RobotQuota(const RobotLimits& limits) : limits_(limits) {}

  /// What speaks against one more session of this robot; empty: nothing. connected: how many others of its sessions are
  /// connected; is_new: the server does not know the session yet.
  std::string objection(const std::string& robot, int connected, bool is_new, Time now) const;

  void began_session(const std::string& robot, Time now);

  /// One keyframe, or cloud, of so many bytes that is to be stored; what speaks against it, empty: nothing. What a
  /// robot may send in a day it may send at once, and then as it comes back over the day.
  std::string stores(const std::string& robot, int keyframes, std::size_t bytes, Time now);

 private:
  /// What is left of a day's allowance.
  struct Allowance {
    double keyframes = 0, bytes = 0;
    Time at;
  };
  Allowance left(const std::string& robot, Time now) const;
  std::string used_up(const std::string& robot, const Allowance& left) const;

  RobotLimits limits_;
  std::map<std::string, Allowance> allowances_;
  std::map<std::string, std::deque<Time>> begun_;  // of each robot the latest, as many as it may begin in a day
};

}  // namespace headframe
