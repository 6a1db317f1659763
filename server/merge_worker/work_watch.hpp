#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "server/session/ids.hpp"

namespace headframe {

/// One piece of the merge worker's work: on two sessions, or on a single one (then a == b).
struct WorkPiece {
  SessionId a = 0, b = 0;
  std::chrono::steady_clock::time_point began;
};

/// Why merging counts as stuck, in words; empty if it does not. Pure.
std::string why_stuck(const std::optional<WorkPiece>& piece, std::chrono::steady_clock::time_point now, double stuck_s);

/// Limits the time of each piece of work: a separate thread raises the flag that the work checks (Cancellable) when a
/// piece has used up its budget. The next piece starts with the flag down. Thread safe.
class WorkWatch {
 public:
  explicit WorkWatch(double budget_s);

  void on(SessionId a, SessionId b);
  void off();
  std::optional<WorkPiece> piece() const;

  /// Raises the flag for good: the current work is no longer wanted.
  void stop();
  bool stopped() const;
  const std::atomic<bool>& flag() const { return flag_; }

 private:
  void watch(const std::stop_token& stop);

  const std::chrono::steady_clock::duration budget_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<WorkPiece> piece_;
  bool stopped_ = false;
  std::atomic<bool> flag_ = false;
  std::jthread thread_;  // last, because it uses the members above
};

}  // namespace headframe
