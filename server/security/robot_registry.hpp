#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// What a robot shows: 32 random bytes that it generated, and at first the code that makes them its credential.
struct Credential {
  std::string token, code;  // empty: none
};

/// Which robots may connect, in memory; RobotGate stores the changes. Times are seconds since the epoch. Thread safe.
class RobotRegistry {
 public:
  static constexpr double code_lifetime_s = 3600;
  static constexpr std::size_t most_robots = 10'000;
  static constexpr std::uint64_t most_rate_kib_s = 1024 * 1024;

  void restore(const std::vector<RobotRecord>& robots);
  std::vector<RobotRecord> robots() const;  // by name

  struct Change {
    RobotRecord after;
    std::optional<RobotRecord> before;  // nullopt: the robot was unknown
  };
  struct Opened {
    std::string code;  // for the operator; only its digest is kept
    Change change;
  };
  /// Opens an enrolment; an earlier code of this robot becomes invalid. A robot that is enrolled stays so until the new
  /// code is used. invalid_argument: an invalid robot name; refused: there are too many robots.
  Result<Opened> open(const std::string& name, double now_s);

  /// From now on neither its token nor an open code is accepted. not_found: no such robot.
  Result<Change> revoke(const std::string& name);

  /// Sets the limit of what the robot may send; 0: none of its own. It stays when the robot enrols again. not_found: no
  /// such robot; invalid_argument: beyond most_rate_kib_s.
  Result<Change> set_rate(const std::string& name, std::uint64_t kib_s);

  /// Accepts the robot, or says why not (refused). Returns a change if the code was used, which makes the token its
  /// credential.
  Result<std::optional<Change>> admit(const std::string& name, const Credential& shown, double now_s);

  /// Whether this token is the robot's valid credential.
  bool holds(const std::string& name, const std::string& token) const;

  /// Undoes a change that could not be stored.
  void take_back(const Change& change);

 private:
  mutable std::mutex mutex_;
  std::map<std::string, RobotRecord> robots_;
};

}  // namespace headframe
