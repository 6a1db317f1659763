#pragma once

#include <chrono>
#include <cmath>

namespace headframe {

/// Bytes per second, averaged with weights that fall to 1/e in ten seconds. Not thread safe.
class DataRate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  void add(double bytes, Time now) {
    bytes_per_s_ = at(now) + bytes / window_s;
    at_ = now;
  }
  double at(Time now) const {
    const double passed_s = std::chrono::duration<double>(now - at_).count();
    return passed_s > 0 ? bytes_per_s_ * std::exp(-passed_s / window_s) : bytes_per_s_;
  }

 private:
  static constexpr double window_s = 10;
  double bytes_per_s_ = 0;
  Time at_{};
};

}  // namespace headframe
