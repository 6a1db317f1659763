#pragma once

#include <mutex>
#include <vector>

#include "server/map_merge_server.hpp"
#include "server/merge_worker/pair_helper.hpp"
#include "server/net/relay.hpp"
#include "server/standby.hpp"
#include "server/store/postgres_presence.hpp"

namespace headframe {

/// This server among those that use its database; over SQLite it is alone. Not thread safe, but for servers().
class Membership {
 public:
  explicit Membership(ServerOptions options);
  ~Membership();
  Membership(const Membership&) = delete;
  Membership& operator=(const Membership&) = delete;

  /// A server that may have to wait makes its ports its own before it does: unavailable when they are in use.
  Result<void> reserve_ports();
  Endpoint listen() const { return options_.listen; }  // with the port that was reserved
  Endpoint http() const { return options_.http; }

  /// How to open the database: at once, or when another server lets go of it. Must not outlive this.
  PostgresOpening opening();

  /// It has the database, and passes nobody on any more: who was connected through it has to come again. It searches
  /// nothing for others any more; what is in progress ends within a moment, for which this does not wait.
  void end_standby();

  /// It is active, and listens there. The fingerprint and the operator's token are empty where it is insecure.
  void serves(const Endpoint& robots, const Endpoint& http, const std::string& fingerprint, const std::string& token);

  /// Who helps the merge pipeline of this server while it is active; null: SQLite. Must not outlive this.
  std::unique_ptr<PairHelpers> helpers() const;

  /// All servers that are there. Does not wait.
  std::vector<ServerRecord> servers() const;

 private:
  Result<void> begin_to_wait(const std::optional<ServerCard>& active);
  Result<void> begin_to_relay();
  std::string operators_at(const Endpoint& http) const;
  StandbyWork work() const;

  ServerOptions options_;
  ServerCard card_;
  std::vector<ReservedPort> ports_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Relay>> relays_;  // while it stands by, and stopped afterwards
  std::unique_ptr<PairHelper> helper_;          // the same
  double since_s_ = 0;
  std::unique_ptr<PostgresPresence> presence_;  // null: SQLite
};

}  // namespace headframe
