#pragma once
// When the uplink may send and when it may try again. Pure: the time is passed in.

#include <chrono>
#include <cstdint>
#include <random>

namespace headframe {

/// A limit in bytes per second; up to a quarter of a second of it can be saved up. 0: no limit. Not thread safe.
class TokenBucket {
 public:
  using Time = std::chrono::steady_clock::time_point;

  TokenBucket(double bytes_per_s, Time now) : bytes_per_s_(bytes_per_s), filled_(now) {}

  /// Takes the bytes and returns how long to wait before sending them.
  std::chrono::duration<double> take(std::size_t bytes, Time now);

  /// Sets the rate from now on; what was saved up or is owed stays.
  void set_rate(double bytes_per_s, Time now);
  double bytes_per_s() const { return bytes_per_s_; }

 private:
  double bytes_per_s_;
  double level_bytes_ = 0;  // below 0: owed
  Time filled_;
};

/// The lower of two limits in bytes per second, where 0 means no limit.
double tighter(double a_bytes_per_s, double b_bytes_per_s);

/// The size of one chunk of a cloud, so that a keyframe waits at most 50 ms behind it: from 256 bytes (with less,
/// headers would outweigh the content) to limits::chunk_bytes.
std::size_t chunk_bytes_at(double bytes_per_s);

/// Exponential backoff with jitter: a random half to all of a span that doubles from `first_s` to `most_s`. Not thread
/// safe.
class Backoff {
 public:
  Backoff(double first_s, double most_s, std::uint32_t seed)
      : first_s_(first_s), most_s_(most_s), span_s_(first_s), random_(seed) {}

  double next_s();
  void reset() { span_s_ = first_s_; }

 private:
  double first_s_, most_s_, span_s_;
  std::mt19937 random_;
};

}  // namespace headframe
