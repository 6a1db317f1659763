#pragma once
// The header with which a standby server tells the active one the address of a client, before the client's bytes:
// version 2 of HAProxy's PROXY protocol, ended by a code that only the servers of this base station can make. All
// functions are pure and thread safe.

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// No other client begins with it: TLS does with 0x16, HTTP with a letter, and a robot's frame in the clear with 0.
inline constexpr unsigned char relay_first_byte = 0x0d;
inline constexpr std::size_t relay_preamble_bytes = 16;  // these contain the length of the rest

/// The key of that code, 32 bytes, derived from the operator's token, which all servers of a base station share. With
/// an empty token (--insecure) anybody can derive it.
std::string relay_key(std::string_view operator_token);

/// `client` and `server` are the two ends of the client's connection; both IPv4, or both IPv6.
std::string relay_header(const boost::asio::ip::tcp::endpoint& client, const boost::asio::ip::tcp::endpoint& server,
                         std::string_view key);

/// How many bytes of the header follow its preamble: 47 for IPv4, 71 for IPv6. bad_input: relay_header makes no header
/// that begins so.
Result<std::size_t> relay_bytes_left(std::string_view preamble);

/// The client's address. `header` is whole. bad_input: relay_header makes none like it; refused: it was made with
/// another key, or `key` is empty.
Result<boost::asio::ip::address> relayed_client(std::string_view header, std::string_view key);

}  // namespace headframe
