#pragma once

#include <chrono>
#include <cstddef>

namespace headframe {

/// Limits of a standby server's relay, for each of its ports; defaults live only here.
struct RelayLimits {
  std::size_t connections = 1024;            // passed on at a time; one more is closed at once
  std::size_t silent = 256;                  // that have said nothing yet; one more, and the oldest of them is closed
  std::size_t buffer_bytes = 16 * 1024;      // of a connection, each way: what was read and not taken yet
  std::chrono::seconds speak_within{10};     // a client has to begin; all of ours do
  std::chrono::seconds connect_within{3};    // the active server has to answer; else the client looks elsewhere
  std::chrono::seconds half_closed_for{30};  // that one side goes on sending after the other has ended
};

}  // namespace headframe
