#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "server/store/postgres.hpp"
#include "server/store/server_record.hpp"

namespace headframe {

/// Called where something is not there yet: waits so long, then it is looked for again. False: it is not waited for any
/// longer.
using WaitForDatabase = std::function<bool(const Error& why, std::chrono::milliseconds pause)>;

/// What a server does that finds the database in use by another one.
struct StandbyPlan {
  /// Called once, before it waits, with what the active server tells of itself (none: it tells nothing). An error: it
  /// can not stand by, and ends.
  std::function<Result<void>(const std::optional<ServerCard>& active)> may_wait;
  WaitForDatabase wait;  // called a few times a second
};

/// Stands by until the database falls free. Not thread safe.
class PostgresStandby {
 public:
  explicit PostgresStandby(StandbyPlan plan) : plan_(std::move(plan)) {}

  /// As take_for_one_server, but waits as long as it takes. unavailable: the connection was lost, and another may be
  /// tried; refused: plan.wait said so. After a lost connection the server that was active has its time to come back
  /// first: where it was the database that went away, nothing has to be taken over.
  Result<void> take(PostgresDatabase& database);

  /// It has begun to wait.
  bool waits() const { return waits_; }

 private:
  Result<void> begin(PostgresDatabase& database);

  const StandbyPlan plan_;
  bool waits_ = false;
};

}  // namespace headframe
