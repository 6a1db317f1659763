#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe {

struct Endpoint {
  std::string host;
  std::uint16_t port = 0;  // 0: any free port
};

/// "HOST:PORT", "[IPV6]:PORT". invalid_argument otherwise.
Result<Endpoint> parse_endpoint(std::string_view text);
/// The same for a server to connect to: port 0 is invalid.
Result<Endpoint> parse_peer(std::string_view text);
/// Several of them, separated by commas.
Result<std::vector<Endpoint>> parse_peers(std::string_view text);
std::string to_string(const Endpoint& endpoint);
/// All addresses of this machine, for listening: 0.0.0.0 or ::. Others cannot connect to it under this name.
bool is_any_address(const Endpoint& endpoint);
/// Reachable from this machine only: a loopback address, or "localhost".
bool is_loopback(const Endpoint& endpoint);

}  // namespace headframe
