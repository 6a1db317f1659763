#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "server/store/postgres.hpp"
#include "server/store/server_record.hpp"

namespace headframe {

/// Called while something is not available yet, with the reason: waits for `pause`, then the caller tries again.
/// Returns false to stop trying.
using WaitForDatabase = std::function<bool(const Error& why, std::chrono::milliseconds pause)>;

/// What a server does if another one uses the database.
struct StandbyPlan {
  /// Called once, before it waits, with the card of the active server, if that published one. An error: it cannot stand
  /// by, and the start fails with this error.
  std::function<Result<void>(const std::optional<ServerCard>& active)> may_wait;
  WaitForDatabase wait;  // called a few times a second
};

/// Waits until no other server uses the database. Not thread safe.
class PostgresStandby {
 public:
  explicit PostgresStandby(StandbyPlan plan) : plan_(std::move(plan)) {}

  /// Takes the database like take_for_one_server, but waits without limit. unavailable: the connection was lost, and
  /// the caller may try again on another one; refused: plan.wait returned false. After a lost connection it first gives
  /// the server that was active time to come back, because if only the database was away, nothing has to be taken over.
  Result<void> take(PostgresDatabase& database);

  /// Whether it has begun to wait.
  bool waits() const { return waits_; }

 private:
  Result<void> begin(PostgresDatabase& database);

  const StandbyPlan plan_;
  bool waits_ = false;
};

}  // namespace headframe
