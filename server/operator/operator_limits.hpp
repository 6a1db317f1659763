#pragma once

#include <chrono>
#include <cstddef>

#include "server/security/attempt_limiter.hpp"

namespace headframe {

struct EventLimits {
  std::size_t clients = 32;                    // further ones are told 503
  std::size_t queued_bytes = 4UL << 20;        // of one client; beyond it all is dropped and a new snapshot sent
  std::chrono::milliseconds look{100};         // between two looks at the station
  std::chrono::milliseconds look_alone{1000};  // the same without clients, for the log alone
};

struct OperatorLimits {
  std::size_t header_bytes = 8 * 1024;
  std::size_t body_bytes = 64 * 1024;
  std::size_t connections = 64;  // further ones are told 503
  double handshake_s = 10;       // of TLS
  double idle_s = 30;            // for a request to come, from the end of the one before it
  double write_s = 30;           // for each piece of a response to leave
  double wait_s = 3600;          // the most that ?wait= may ask for
  EventLimits events;
  /// Requests of one address at once, and how many more each second; further ones are told 429. Those with the token
  /// and those without count apart, so that a stranger on the same address keeps no operator out.
  AttemptLimits requests{.failures = 3000, .forgiven_per_s = 1000, .addresses = 4096};
};

}  // namespace headframe
