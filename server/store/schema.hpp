#pragma once

#include "server/store/sqlite.hpp"

namespace headframe {

/// The version this server writes. A database says its own in PRAGMA user_version.
int schema_version();

/// Brings a database to schema_version(), each step in a transaction of its own. incompatible: it is newer.
Result<void> migrate(SqliteDatabase& database);

}  // namespace headframe
