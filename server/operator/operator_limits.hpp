#pragma once

#include <chrono>
#include <cstddef>

#include "server/security/attempt_limiter.hpp"

namespace headframe {

struct EventLimits {
  std::size_t clients = 32;                    // further ones are answered 503
  std::size_t queued_bytes = 4UL << 20;        // per client; beyond it the queue is replaced by a snapshot
  std::chrono::milliseconds look{100};         // interval at which the station is polled
  std::chrono::milliseconds look_alone{1000};  // the same without clients, only for the log
};

struct OperatorLimits {
  std::size_t header_bytes = 8 * 1024;
  std::size_t body_bytes = 64 * 1024;
  std::size_t connections = 64;  // HttpShared::accept says what happens to further ones
  double handshake_s = 10;       // for the TLS handshake
  double idle_s = 30;            // for a whole request to arrive, after the response before it
  double write_s = 30;           // for each piece of a response to be sent
  double wait_s = 3600;          // maximum of ?wait=
  EventLimits events;
  /// Requests of one address: how many at once, and how many more each second; further ones are answered 429. Requests
  /// with and without the token are counted separately, so that a stranger cannot lock out an operator on the same
  /// address.
  AttemptLimits requests{.failures = 3000, .forgiven_per_s = 1000, .addresses = 4096};
};

}  // namespace headframe
