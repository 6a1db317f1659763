#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "common/endpoint.hpp"
#include "common/result.hpp"

namespace headframe {

/// Opens the acceptor and binds it to `at`, an address of this machine or a name of one; port 0 takes any. It does not
/// listen yet. The error of the step that failed, or none. Resolves names, which may wait.
boost::system::error_code bind_port(boost::asio::ip::tcp::acceptor& acceptor, const Endpoint& at);

/// unavailable: why nobody can be served at `at`, and what to do about it.
tl::unexpected<Error> listen_failure(const Endpoint& at, const boost::system::error_code& why);

}  // namespace headframe
