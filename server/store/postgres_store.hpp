#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>

#include "server/store/store.hpp"
#include "server/store/store_options.hpp"

namespace headframe {

/// Called where the database does not answer when a store is opened: waits so long, then it is looked for again. False:
/// it is not waited for any longer.
using WaitForDatabase = std::function<bool(const Error& why, std::chrono::milliseconds pause)>;

/// Opens the database of a postgresql:// URL, made ready when it is empty, for this server alone: sessions and all that
/// robots have sent lie there, and `directory`, created and locked, holds what is this server's own. One writer thread
/// with group commit; while the database is away the writes wait, and go on when it is back. unavailable: no server
/// answers there (no longer, if `wait` is given), it is a standby, or the directory can not be written or is in use;
/// refused: another server uses the database, or the directory holds a database of its own; incompatible: a newer
/// schema; bad_input: the URL, role, database or password are wrong, or what PostgreSQL acknowledges is not durable.
Result<std::unique_ptr<Store>> open_postgres_store(const std::filesystem::path& directory, const std::string& url,
                                                   const StoreOptions& options = {.retry_ms = 100,
                                                                                  .longest_retry_ms = 2000},
                                                   const WaitForDatabase& wait = {});

}  // namespace headframe
