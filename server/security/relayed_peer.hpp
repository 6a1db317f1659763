#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <optional>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// Waits for the first byte and looks at it without reading it: relay_first_byte begins a relay's header. `done` gets
/// it on the socket's executor; nullopt: the connection ended, or the wait was cancelled. The socket must live until
/// then; closing it ends the wait.
void async_first_byte(boost::asio::ip::tcp::socket& socket, std::function<void(std::optional<unsigned char>)> done);

/// Reads a relay's header, and no byte more: `done` gets the client's address, on the socket's executor. Errors are
/// those of relayed_client; unavailable: the connection ended, or the header was not there within two seconds. The
/// socket must live until then; closing it ends the read.
void async_read_relay_header(boost::asio::ip::tcp::socket& socket, std::string key,
                             std::function<void(const Result<boost::asio::ip::address>&)> done);

}  // namespace headframe
