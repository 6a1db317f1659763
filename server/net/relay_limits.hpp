#pragma once

#include <chrono>
#include <cstddef>

namespace headframe {

/// Limits of a standby server's relay, for each of its ports; defaults live only here.
struct RelayLimits {
  std::size_t connections = 1024;            // at a time; further ones are closed at once
  std::size_t silent = 256;                  // that have sent nothing yet; for a further one the oldest is closed
  std::size_t buffer_bytes = 16 * 1024;      // per connection and direction: read, but not yet written
  std::chrono::seconds speak_within{10};     // the client has to send its first byte; all ours speak first
  std::chrono::seconds connect_within{3};    // the active server has to accept; else the client may try another
  std::chrono::seconds half_closed_for{30};  // one side may go on sending after the other has ended
};

}  // namespace headframe
