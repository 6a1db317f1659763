#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "server/store/postgres_standby.hpp"
#include "server/store/store.hpp"
#include "server/store/store_options.hpp"

namespace headframe {

struct PostgresOpening {
  WaitForDatabase wait_for_database = {};   // none: where no server answers, opening fails
  std::int64_t mark = 0;                    // of this server, in the database; 0: a random one
  std::optional<StandbyPlan> standby = {};  // none: a database that another server uses is refused
};

/// Opens the database of a postgresql:// URL, made ready when it is empty, for this server alone: sessions and all that
/// robots have sent lie there, and `directory`, created and locked, holds what is this server's own. One writer thread
/// with group commit; while the database is away the writes wait, and go on when it is back. unavailable: no server
/// answers there (no longer, if it is waited for), it is a standby, or the directory can not be written or is in use;
/// refused: another server uses the database and is not waited for (any longer), or the directory holds a database of
/// its own; incompatible: a newer
/// schema; bad_input: the URL, role, database or password are wrong, or what PostgreSQL acknowledges is not durable.
Result<std::unique_ptr<Store>> open_postgres_store(const std::filesystem::path& directory, const std::string& url,
                                                   const StoreOptions& options = {.retry_ms = 100,
                                                                                  .longest_retry_ms = 2000},
                                                   const PostgresOpening& opening = {});

}  // namespace headframe
