#pragma once
// What a server needs that takes over from another one, beside the database: to be known as the same.

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/endpoint.hpp"
#include "common/result.hpp"
#include "server/store/server_record.hpp"

namespace headframe {

/// By what robots and operators know the server of this data directory, in the two fields of a card. Makes nothing.
/// refused: a file is not there; errors of server_identity and operator_token.
Result<ServerCard> known_by(const std::filesystem::path& data);

/// refused: robots and operators would not take the server of this data directory for the active one; the line says
/// which files to copy from where. `active`: what that one tells of itself; none: it tells nothing, and files that are
/// there are believed.
Result<void> fit_to_stand_by(const std::filesystem::path& data, const std::optional<ServerCard>& active);

/// A port that this server will listen on: nobody else gets it meanwhile. Who connects to it is turned away, unless a
/// Relay listens there.
class ReservedPort {
 public:
  /// unavailable: the port is in use, or the address is not of this machine.
  static Result<ReservedPort> at(const Endpoint& endpoint);
  const Endpoint& endpoint() const { return endpoint_; }  // with the real port

 private:
  ReservedPort() : io_(std::make_unique<boost::asio::io_context>(1)), socket_(*io_) {}

  std::unique_ptr<boost::asio::io_context> io_;
  boost::asio::ip::tcp::acceptor socket_;  // bound, and does not listen
  Endpoint endpoint_;
};

}  // namespace headframe
