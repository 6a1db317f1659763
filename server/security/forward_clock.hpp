#pragma once

#include <functional>
#include <mutex>

namespace headframe {

/// Seconds since the epoch that never go back: whoever sets the machine's clock back gets no time back. Between two
/// looks as much time passes as passed, whatever the machine's clock says. Thread safe.
class ForwardClock {
 public:
  using Clock = std::function<double()>;  // seconds
  /// wall: since the epoch, as the machine says. steady: since whenever; nobody can set it.
  ForwardClock(Clock wall, Clock steady) : wall_(std::move(wall)), steady_(std::move(steady)), looked_s_(steady_()) {}

  double now_s() const;
  /// It is not earlier than this, as something that is stored says.
  void at_least(double seen_s);

 private:
  const Clock wall_, steady_;
  mutable std::mutex mutex_;
  mutable double now_s_ = 0, looked_s_;  // looked_s_: of steady_
};

}  // namespace headframe
