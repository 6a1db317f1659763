#pragma once

#include <functional>

#include "server/security/attempt_limiter.hpp"
#include "server/security/forward_clock.hpp"
#include "server/security/revocation_log.hpp"
#include "server/security/robot_registry.hpp"

namespace headframe {

/// Authenticates robots, and lets operators decide which are allowed. What it confirms is on the disk. Thread safe;
/// does not block, except restore() and revoke(). Callbacks run once: at once, or on the store's writer thread; they
/// must not call the gate.
class RobotGate {
 public:
  /// Clocks for tests, and callbacks. `ended` has to cut the connections of a robot whose credential has ended.
  struct Seams {
    std::function<double()> now_s;  // seconds since the epoch; empty: the system's
    std::function<void(const std::string& robot, const std::string& why)> ended;
    std::function<void(const std::string& robot, std::uint64_t kib_s)> rated;  // what it may send; 0: no limit
    std::function<double()> steady_s = {};  // of a clock that cannot be set; empty: the system's
  };
  /// revocations: where revocations wait while the disk is full; null: then those that wait are lost if the process
  /// ends.
  RobotGate(Store& store, Seams seams, const AttemptLimits& limits = {}, RevocationLog* revocations = nullptr);

  Result<void> restore();

  /// refused: wrong credential. unavailable: the disk failed, or too many attempts from this address failed, so that
  /// codes are not checked for a while. A valid token is accepted even then, because many robots may share one
  /// gateway's address, and one of them must not lock out the others.
  void admit(const std::string& robot, const Credential& shown, const boost::asio::ip::address& from,
             AttemptLimiter::Time now, const std::function<void(const Result<void>&)>& done);
  /// Whether the credential is still valid.
  bool holds(const std::string& robot, const std::string& token) const { return registry_.holds(robot, token); }

  /// Call when an unknown peer failed before showing a credential. False: it failed too often to log it again.
  bool worth_a_line(const boost::asio::ip::address& from, AttemptLimiter::Time now);

  /// Opens an enrolment and returns the code.
  void open(const std::string& robot, const std::function<void(const Result<std::string>&)>& done);
  /// The robot is disconnected before this returns. `done` says that the revocation is on the disk, even on a full one.
  /// Blocks for the disk.
  void revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done);
  /// `done` says that it is on the disk, and that the robot was told if it is connected.
  void set_rate(const std::string& robot, std::uint64_t kib_s, const std::function<void(const Result<void>&)>& done);
  std::vector<RobotRecord> robots() const { return registry_.robots(); }
  double now_s() const { return clock_.now_s(); }

 private:
  void revoke_again(const std::vector<RobotRecord>& stored);
  void keep(const RobotRegistry::Change& change, const std::function<void(const Result<void>&)>& done);

  Store& store_;
  const Seams seams_;
  ForwardClock clock_;
  std::mutex order_;  // so that changes reach the store in the order in which they were made
  RobotRegistry registry_;
  AttemptLimiter attempts_, lines_;
  RevocationLog* const revocations_;
};

}  // namespace headframe
