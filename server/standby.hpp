#pragma once
// What a standby server needs besides the database: the identity of the active server, and free ports.

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/endpoint.hpp"
#include "common/result.hpp"
#include "server/store/server_record.hpp"

namespace headframe {

/// The certificate's fingerprint and the digest of the token in this data directory, by which robots and operators
/// recognise the server; the other fields of the card stay empty. Creates no file. refused: a file is missing; also
/// fails like server_identity and operator_token.
Result<ServerCard> known_by(const std::filesystem::path& data);

/// Checks that robots and operators will accept the server of this data directory in place of the active one. `active`
/// is the card of the active server; if there is none, it is only checked that the files exist and are valid. refused:
/// they will not accept it; the message says which files to copy from where.
Result<void> fit_to_stand_by(const std::filesystem::path& data, const std::optional<ServerCard>& active);

/// Reserves a port on which this server will listen later, so that no other program takes it meanwhile. Connections to
/// it are refused until a Relay listens there.
class ReservedPort {
 public:
  /// unavailable: the port is in use, or the address is not of this machine.
  static Result<ReservedPort> at(const Endpoint& endpoint);
  const Endpoint& endpoint() const { return endpoint_; }  // with the actual port, if 0 was asked for

 private:
  ReservedPort() : io_(std::make_unique<boost::asio::io_context>(1)), socket_(*io_) {}

  std::unique_ptr<boost::asio::io_context> io_;
  boost::asio::ip::tcp::acceptor socket_;  // bound, but not listening
  Endpoint endpoint_;
};

}  // namespace headframe
