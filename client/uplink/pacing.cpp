#include "client/uplink/pacing.hpp"

#include <algorithm>

namespace headframe {

std::chrono::duration<double> TokenBucket::take(std::size_t bytes, Time now) {
  if (bytes_per_s_ <= 0) return {};
  const std::chrono::duration<double> passed = now - filled_;
  filled_ = now;
  level_bytes_ = std::min(level_bytes_ + passed.count() * bytes_per_s_, bytes_per_s_ / 4);
  level_bytes_ -= static_cast<double>(bytes);
  return std::chrono::duration<double>(std::max(0.0, -level_bytes_ / bytes_per_s_));
}

double Backoff::next_s() {
  const double wait_s = std::uniform_real_distribution<double>(span_s_ / 2, span_s_)(random_);
  span_s_ = std::min(span_s_ * 2, most_s_);
  return wait_s;
}

}  // namespace headframe
