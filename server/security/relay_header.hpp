#pragma once
// What a server that stands by tells the active one of a client whose bytes follow: version 2 of HAProxy's PROXY
// protocol, and a code that only the servers of this base station can make. All functions are pure and thread safe.

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// No other client begins with it: TLS does with 0x16, HTTP with a letter, and a robot's frame in the clear with 0.
inline constexpr unsigned char relay_first_byte = 0x0d;
inline constexpr std::size_t relay_preamble_bytes = 16;  // they tell how long the header is

/// Of the operator's token, which all servers of a base station have; empty: they run with --insecure, and anybody can
/// make the key. 32 bytes.
std::string relay_key(std::string_view operator_token);

/// `client` is who connected, `server` where it did; of the same version of IP.
std::string relay_header(const boost::asio::ip::tcp::endpoint& client, const boost::asio::ip::tcp::endpoint& server,
                         std::string_view key);

/// How many bytes of the header follow its preamble: 47 for IPv4, 71 for IPv6. bad_input: it is the beginning of no
/// header that relay_header makes.
Result<std::size_t> relay_bytes_left(std::string_view preamble);

/// The client's address. `header` is whole. bad_input: relay_header makes none like it; refused: it was made with
/// another key, or `key` is empty.
Result<boost::asio::ip::address> relayed_client(std::string_view header, std::string_view key);

}  // namespace headframe
