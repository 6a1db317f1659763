#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "server/store/postgres_standby.hpp"
#include "server/store/store.hpp"
#include "server/store/store_options.hpp"

namespace headframe {

struct PostgresOpening {
  WaitForDatabase wait_for_database = {};   // empty: opening fails if no server answers
  std::int64_t mark = 0;                    // names this server in the database; 0: a random one
  std::optional<StandbyPlan> standby = {};  // nullopt: a database that another server uses is refused
};

/// Opens the database of a postgresql:// URL for this server alone, and creates its tables if necessary. It holds the
/// sessions and all that robots have sent; `directory`, which is created and locked, holds this server's own files. One
/// writer thread with group commit; while the database is unreachable, writes wait. unavailable: no server answers
/// there (or waiting was ended), it is a replica, or the directory cannot be written or is in use; refused: another
/// server uses the database (or waiting was ended), or the directory holds a database of its own; incompatible: a newer
/// schema; bad_input: the URL, role, database or password is wrong, or commits that PostgreSQL acknowledges are not
/// durable.
Result<std::unique_ptr<Store>> open_postgres_store(const std::filesystem::path& directory, const std::string& url,
                                                   const StoreOptions& options = {.retry_ms = 100,
                                                                                  .longest_retry_ms = 2000},
                                                   const PostgresOpening& opening = {});

}  // namespace headframe
