#pragma once
// The servers of one base station: one serves, others pass connections on to it and may take over.

#include <cstdint>
#include <optional>
#include <string>

namespace headframe {

/// What a server tells the others that use its database.
struct ServerCard {
  std::int64_t id = 0;            // random, of this run of it; while it is active, the mark in table writer
  std::string name;               // for people: [server] name, or the host and its data directory
  std::string robots, http;       // HOST:PORT where it serves them, or will
  std::string fingerprint = {};   // 32 bytes, of the certificate that robots know it by; empty: insecure
  std::string token_digest = {};  // 32 bytes, SHA-256 of the operator's token; empty: insecure
  std::string loopback = {};      // a name of the loopback that it shares with others on this machine alone
};

/// What a standby server does for the active one.
struct StandbyWork {
  int relayed = 0;                              // connections that it passes on now
  std::int64_t searched = 0;                    // pairs of sessions that it has searched since it started
  std::int64_t searches_a = 0, searches_b = 0;  // the pair that it searches now; 0: none
};

/// A server as the others see it.
struct ServerRecord {
  std::string name;
  std::string robots, http;
  bool is_active = false;  // it serves; else it waits to take over
  bool is_self = false;
  double since_s = 0;      // when it began to be so, since the epoch
  double heard_ago_s = 0;  // its last sign of life
  /// Connections that it passes on to the active one now. None: the database has the schema of an older server, so that
  /// the active one may be one that knows nothing of it.
  std::optional<int> relayed = std::nullopt;
  bool shares_loopback = false;  // with the server that sees it: addresses on the loopback mean the same to both
  std::int64_t searched = 0;     // pairs of sessions that it has searched for the active server
  std::int64_t searches_a = 0, searches_b = 0;  // the pair that it searches now; 0: none
};

}  // namespace headframe
