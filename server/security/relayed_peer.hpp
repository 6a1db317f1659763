#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// Whether the first byte that waits in the socket is that of a relay's header; nothing is read. Does not wait.
bool begins_with_relay_header(boost::asio::ip::tcp::socket& socket);

/// Reads a relay's header, and no byte more: `done` gets the client's address, on the socket's executor. Errors are
/// those of relayed_client; unavailable: the connection ended, or the header was not there within two seconds. The
/// socket must live until then; closing it ends the read.
void async_read_relay_header(boost::asio::ip::tcp::socket& socket, std::string key,
                             std::function<void(const Result<boost::asio::ip::address>&)> done);

}  // namespace headframe
