#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// What a robot shows: 32 random bytes that it made itself, and once the code that makes them its credential.
struct Credential {
  std::string token, code;  // empty: none
};

/// Who may be a robot here, in memory; RobotGate stores what changes. Times are seconds since the epoch. Thread safe.
class RobotRegistry {
 public:
  static constexpr double code_lifetime_s = 3600;
  static constexpr std::size_t most_robots = 10'000;
  static constexpr std::uint64_t most_rate_kib_s = 1024 * 1024;

  void restore(const std::vector<RobotRecord>& robots);
  std::vector<RobotRecord> robots() const;  // by name

  struct Change {
    RobotRecord after;
    std::optional<RobotRecord> before;  // nullopt: it was not known
  };
  struct Opened {
    std::string code;  // to be told to the operator; only its digest is kept
    Change change;
  };
  /// Opens an enrolment; an earlier code of this robot ends. A robot that is enrolled stays so until the new code is
  /// used. invalid_argument: no name for a robot; refused: there are too many robots.
  Result<Opened> open(const std::string& name, double now_s);

  /// From now on neither its token nor an open code lets it in. not_found: there is no such robot.
  Result<Change> revoke(const std::string& name);

  /// What it may send at most; 0: no limit of its own. It stays when the robot enrols anew. not_found: there is no such
  /// robot; invalid_argument: beyond most_rate_kib_s.
  Result<Change> set_rate(const std::string& name, std::uint64_t kib_s);

  /// Lets the robot in, or says why not (refused). A change: the code was used, and the token is its credential now.
  Result<std::optional<Change>> admit(const std::string& name, const Credential& shown, double now_s);

  /// Whether this token lets this robot in.
  bool holds(const std::string& name, const std::string& token) const;

  /// The change could not be stored: as if it had not been.
  void take_back(const Change& change);

 private:
  mutable std::mutex mutex_;
  std::map<std::string, RobotRecord> robots_;
};

}  // namespace headframe
