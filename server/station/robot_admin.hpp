#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe {

struct RobotRow {
  std::string robot;
  std::string state;             // invited: a code is open; enrolled; revoked; expired: it never used its code
  double enrolled_s = 0;         // since the epoch; 0: never
  double code_expires_s = 0;     // since the epoch; 0: no code is open
  std::uint64_t rate_kib_s = 0;  // what it may send at most; 0: no limit of its own
};

/// Which robots may come in, as the operator sees and decides it. Thread safe and quick; callbacks run once, from any
/// thread, when what they say is on the disk.
class RobotAdmin {
 public:
  virtual ~RobotAdmin() = default;
  virtual std::vector<RobotRow> robots() const = 0;
  /// Of the certificate, hexadecimal.
  virtual std::string fingerprint() const = 0;
  /// HOST:PORT where robots come; empty: not known.
  virtual std::string address() const { return {}; }
  /// Gives the one string that the robot needs to enrol.
  virtual void add(const std::string& robot, const std::function<void(const Result<std::string>&)>& done) = 0;
  virtual void revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done) = 0;
  /// From now on, also on a connection that is there. 0: no limit of its own.
  virtual void set_rate(const std::string& robot, std::uint64_t kib_s,
                        const std::function<void(const Result<void>&)>& done) = 0;
};

}  // namespace headframe
