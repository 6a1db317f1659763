#pragma once

#include <cstddef>

namespace headframe {

/// How many bytes of clouds may be added to what the kernel still holds of this TCP socket, so that on a slow link a
/// keyframe waits at most half a second behind them: none while the kernel holds more than the link delivers in a round
/// trip plus half a second, else what the link delivers in 50 ms. `most` if the kernel does not report it.
std::size_t kernel_room(int socket, std::size_t most);

/// Whether this TCP connection had to retransmit more than this share of its packets, and more than two of them. False
/// if the kernel does not report it.
bool loses_packets(int socket, double share);

}  // namespace headframe
