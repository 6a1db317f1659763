#include "client/uplink/pacing.hpp"

#include <algorithm>

#include "common/wire/limits.hpp"

namespace headframe {

std::chrono::duration<double> TokenBucket::take(std::size_t bytes, Time now) {
  if (bytes_per_s_ <= 0) return {};
  const std::chrono::duration<double> passed = std::max(Time::duration::zero(), now - filled_);
  filled_ = now;
  level_bytes_ = std::min(level_bytes_ + passed.count() * bytes_per_s_, bytes_per_s_ / 4);
  level_bytes_ -= static_cast<double>(bytes);
  return std::chrono::duration<double>(std::max(0.0, -level_bytes_ / bytes_per_s_));
}

void TokenBucket::set_rate(double bytes_per_s, Time now) {
  (void)take(0, now);
  if (bytes_per_s_ <= 0) filled_ = now;  // an unlimited one saves nothing
  bytes_per_s_ = bytes_per_s;
}

double tighter(double a_bytes_per_s, double b_bytes_per_s) {
  if (a_bytes_per_s <= 0 || b_bytes_per_s <= 0) return std::max(a_bytes_per_s, b_bytes_per_s);
  return std::min(a_bytes_per_s, b_bytes_per_s);
}

std::size_t chunk_bytes_at(double bytes_per_s) {
  constexpr double behind_chunk_s = 0.05, header_bytes = 32, least = 256;
  if (bytes_per_s <= 0) return limits::chunk_bytes;
  const double bytes = bytes_per_s * behind_chunk_s - header_bytes;
  return static_cast<std::size_t>(std::clamp(bytes, least, static_cast<double>(limits::chunk_bytes)));
}

double Backoff::next_s() {
  const double wait_s = std::uniform_real_distribution<double>(span_s_ / 2, span_s_)(random_);
  span_s_ = std::min(span_s_ * 2, most_s_);
  return wait_s;
}

}  // namespace headframe
