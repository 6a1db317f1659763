#pragma once

#include <functional>

#include "server/security/attempt_limiter.hpp"
#include "server/security/forward_clock.hpp"
#include "server/security/revocation_log.hpp"
#include "server/security/robot_registry.hpp"

namespace headframe {

/// Lets robots in, and operators decide which. What it says yes to is on the disk. Thread safe; never blocks but in
/// restore(). Callbacks run once: at once, or on the store's writer; they must not call the gate.
class RobotGate {
 public:
  struct Seams {  // a test's clock, and who cuts the connections of a robot whose credential has ended
    std::function<double()> now_s;  // since the epoch; empty: the system's
    std::function<void(const std::string& robot, const std::string& why)> ended;
    std::function<void(const std::string& robot, std::uint64_t kib_s)> rated;  // what it may send; 0: no limit
    std::function<double()> steady_s = {};  // of a clock that nobody sets; empty: the system's
  };
  /// revocations: where they wait for a disk that is full; null: nowhere, and those that wait are lost with the
  /// process.
  RobotGate(Store& store, Seams seams, const AttemptLimits& limits = {}, RevocationLog* revocations = nullptr);

  Result<void> restore();

  /// refused: not with this credential. unavailable: too many attempts from this address have failed, so that its codes
  /// are not looked at for a while (a token that fits is let in all the same: a gateway may stand before many robots,
  /// and one of them must not lock the others out); or the disk.
  void admit(const std::string& robot, const Credential& shown, const boost::asio::ip::address& from,
             AttemptLimiter::Time now, const std::function<void(const Result<void>&)>& done);
  /// Whether the credential has not ended since.
  bool holds(const std::string& robot, const std::string& token) const { return registry_.holds(robot, token); }

  /// A stranger failed before he could show anything. False: he did so too often for another line in the log.
  bool worth_a_line(const boost::asio::ip::address& from, AttemptLimiter::Time now);

  /// Gives the code.
  void open(const std::string& robot, const std::function<void(const Result<std::string>&)>& done);
  /// The robot is cut off before this returns; `done` says that it is on the disk, be that full. Waits for the disk.
  void revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done);
  /// `done` says that it is on the disk, and that robots that are connected were told.
  void set_rate(const std::string& robot, std::uint64_t kib_s, const std::function<void(const Result<void>&)>& done);
  std::vector<RobotRecord> robots() const { return registry_.robots(); }
  double now_s() const { return clock_.now_s(); }

 private:
  void revoke_again(const std::vector<RobotRecord>& stored);
  void keep(const RobotRegistry::Change& change, const std::function<void(const Result<void>&)>& done);

  Store& store_;
  const Seams seams_;
  ForwardClock clock_;
  std::mutex order_;  // changes reach the store in the order in which they were made
  RobotRegistry registry_;
  AttemptLimiter attempts_, lines_;
  RevocationLog* const revocations_;
};

}  // namespace headframe
