#pragma once

#include <cstdint>
#include <string>

namespace headframe {

/// The robots' connections, all together, since the server started.
struct LinkHealth {
  std::string hold;                  // why nothing is acknowledged now (a full disk); empty: all is well
  std::uint64_t queued_bytes = 0;    // that wait for the disk
  std::uint64_t refused = 0;         // hellos
  std::uint64_t replaced = 0;        // by a newer connection of the same robot
  std::uint64_t failed = 0;          // ended with an error: bad bytes, silence, a full write queue
  std::uint64_t stuck = 0;           // took no bytes until the deadline
  std::uint64_t held_back = 0;       // times that a robot outran the disk and was not read
  std::uint64_t refused_clouds = 0;  // damaged ones: the robot dropped them and went on
  std::uint64_t sent_bytes = 0;      // to robots, before TLS
};

}  // namespace headframe
