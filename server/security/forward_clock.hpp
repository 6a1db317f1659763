#pragma once

#include <functional>
#include <mutex>

namespace headframe {

/// Seconds since the epoch that never go back, even if the machine's clock is set back. Between two calls the time
/// advances by what really passed, whatever the machine's clock says. Thread safe.
class ForwardClock {
 public:
  using Clock = std::function<double()>;  // seconds
  /// wall: the machine's time since the epoch. steady: since an arbitrary start, from a clock that cannot be set.
  ForwardClock(Clock wall, Clock steady) : wall_(std::move(wall)), steady_(std::move(steady)), looked_s_(steady_()) {}

  double now_s() const;
  /// The time is at least this, according to something that is stored.
  void at_least(double seen_s);

 private:
  const Clock wall_, steady_;
  mutable std::mutex mutex_;
  mutable double now_s_ = 0, looked_s_;  // looked_s_: by steady_
};

}  // namespace headframe
