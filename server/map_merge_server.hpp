#pragma once
// The complete base station: store, robots' connections, merge worker, operator API.

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
  bool insecure = false;                   // neither TLS nor tokens: everybody who reaches the ports may use them
  bool new_identity = false;               // allows a new key if the one that enrolled robots know is missing
  WaitForDatabase wait_for_database = {};  // empty: the start fails if the database does not answer
  // For a server that may become a standby (config.standby). on_standby is called once, before it waits, with the
  // addresses on which it will serve. wait_for_turn is called a few times a second while it waits; if it returns false,
  // the start ends.
  std::function<void(const Endpoint& robots, const Endpoint& http)> on_standby = {};
  WaitForDatabase wait_for_turn = {};
  /// Called once, on one of the server's threads, if another server took over while this one was cut off from
  /// PostgreSQL. This server then writes nothing any more; the caller has to end it.
  std::function<void(const Error& why)> on_taken_over = {};
};

/// Runs from start() until it is destroyed. Continues with what its data directory and database contain.
class MapMergeServer {
 public:
  /// unavailable: the directory cannot be written or is in use, a port cannot be opened, or the database does not
  /// answer; incompatible: the database has a newer schema; refused: the server's identity is lost, another server uses
  /// the database, this server is not fit to be a standby, or waiting was ended; bad_input: the database's URL or
  /// credentials are wrong, or a file has invalid content; invalid_argument: options contradict each other, or the
  /// operators' address is not of this machine.
  static Result<std::unique_ptr<MapMergeServer>> start(const ServerOptions& options);

  /// Stops serving, finishes the merge attempt in progress, and writes what was received.
  ~MapMergeServer();

  const Endpoint& robots() const;  // with the actual port
  const Endpoint& http() const;
  bool https() const;                      // whether operators are served over TLS
  const std::string& fingerprint() const;  // of the certificate, 32 bytes; empty: insecure

 private:
  struct Parts;
  explicit MapMergeServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace headframe
