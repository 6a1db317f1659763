#include "server/security/forward_clock.hpp"

#include <algorithm>

namespace headframe {

double ForwardClock::now_s() const {
  const std::lock_guard lock(mutex_);
  const double steady_s = steady_(), passed_s = std::max(0.0, steady_s - looked_s_);
  now_s_ = std::max(wall_(), now_s_ + passed_s);
  looked_s_ = steady_s;
  return now_s_;
}

void ForwardClock::at_least(double seen_s) {
  const std::lock_guard lock(mutex_);
  now_s_ = std::max(now_s_, seen_s);
}

}  // namespace headframe
