#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe {

struct Endpoint {
  std::string host;
  std::uint16_t port = 0;  // 0: any that is free
};

/// "HOST:PORT", "[IPV6]:PORT". invalid_argument otherwise.
Result<Endpoint> parse_endpoint(std::string_view text);
/// The same, of somebody to connect to: port 0 is none.
Result<Endpoint> parse_peer(std::string_view text);
/// Several of them, with commas between.
Result<std::vector<Endpoint>> parse_peers(std::string_view text);
std::string to_string(const Endpoint& endpoint);
/// Every address of this machine, to listen on: 0.0.0.0 or ::. Nobody can connect to it from elsewhere.
bool is_any_address(const Endpoint& endpoint);
/// Reached from this machine only: an address of the loopback, or "localhost".
bool is_loopback(const Endpoint& endpoint);

}  // namespace headframe
