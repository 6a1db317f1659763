#pragma once

#include "server/store/sqlite.hpp"

namespace headframe {

/// The version that this server writes. A database has its version in PRAGMA user_version.
int schema_version();

/// Updates a database to schema_version(), each step in its own transaction. incompatible: it is newer.
Result<void> migrate(SqliteDatabase& database);

}  // namespace headframe
