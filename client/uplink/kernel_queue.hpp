#pragma once

#include <cstddef>

namespace headframe {

/// How many bytes of clouds may follow what the kernel holds of this TCP socket, so that a keyframe waits half a second
/// at most behind them on a thin link: none while it holds more than the link delivers in its round trip and half a
/// second, else what the link delivers in 50 ms. `most` where the kernel does not say.
std::size_t kernel_room(int socket, std::size_t most);

/// Whether this TCP connection had to send more than this share of its packets again, and more than two of them. false
/// where the kernel does not say.
bool loses_packets(int socket, double share);

}  // namespace headframe
