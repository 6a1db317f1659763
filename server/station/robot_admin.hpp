#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe {

struct RobotRow {
  std::string robot;
  std::string state;             // invited: has an open code; enrolled; revoked; expired: did not use its code in time
  double enrolled_s = 0;         // since the epoch; 0: never
  double code_expires_s = 0;     // since the epoch; 0: no code is open
  std::uint64_t rate_kib_s = 0;  // limit of what it may send; 0: none of its own
};

/// The operator's control over which robots may connect. Thread safe and fast, except revoke(), which waits for a small
/// write to the disk. Callbacks run once, from any thread, when the change is on the disk.
class RobotAdmin {
 public:
  virtual ~RobotAdmin() = default;
  virtual std::vector<RobotRow> robots() const = 0;
  /// Of the server's certificate, hexadecimal.
  virtual std::string fingerprint() const = 0;
  /// HOST:PORT for robots; empty: unknown.
  virtual std::string address() const { return {}; }
  /// Returns the string that the robot needs to enrol.
  virtual void add(const std::string& robot, const std::function<void(const Result<std::string>&)>& done) = 0;
  virtual void revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done) = 0;
  /// Takes effect at once, also on an existing connection. 0: no limit of its own.
  virtual void set_rate(const std::string& robot, std::uint64_t kib_s,
                        const std::function<void(const Result<void>&)>& done) = 0;
};

}  // namespace headframe
