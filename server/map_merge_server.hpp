#pragma once
// The whole base station, put together: store, robots, merge worker, operator API.

#include <filesystem>
#include <functional>
#include <memory>

#include "common/endpoint.hpp"
#include "server/config/server_config.hpp"
#include "server/store/postgres_store.hpp"

namespace headframe {

struct ServerOptions {
  std::filesystem::path data;
  Endpoint listen;  // for robots
  Endpoint http;    // for operators
  ServerConfig config;
  bool insecure = false;      // neither TLS nor tokens: who reaches the ports may use them
  bool new_identity = false;  // where the key is missing by which enrolled robots know the server, another may be made
  WaitForDatabase wait_for_database = {};  // none: the start fails where the database does not answer
  // Of a server that may stand by (config.standby). on_standby is called once, before it waits, with where it will
  // serve; wait_for_turn a few times a second while it waits, and ends the start when it says false.
  std::function<void(const Endpoint& robots, const Endpoint& http)> on_standby = {};
  WaitForDatabase wait_for_turn = {};
  /// Another server has taken over while this one was cut off from PostgreSQL: it writes nothing any more, and whoever
  /// runs it has to end it. Called once, from a thread of the server's.
  std::function<void(const Error& why)> on_taken_over = {};
};

/// Runs from start() to stop(); restored from its data directory, and its database, when there is something in them.
class MapMergeServer {
 public:
  /// unavailable: the directory can not be written or is in use, a port is taken, the database does not answer;
  /// incompatible: a newer schema; refused: the server's identity is lost, another server uses the database, this one
  /// is not fit to stand by, or waiting was ended; bad_input: the database's URL, or who is let in there.
  static Result<std::unique_ptr<MapMergeServer>> start(const ServerOptions& options);

  /// stop(): no robot is served any more, the running attempt is finished, what was received is written.
  ~MapMergeServer();

  const Endpoint& robots() const;  // with the real port
  const Endpoint& http() const;
  bool https() const;                      // where operators come
  const std::string& fingerprint() const;  // of the certificate, 32 bytes; empty: insecure

 private:
  struct Parts;
  explicit MapMergeServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace headframe
