#pragma once

#include "server/store/postgres.hpp"

namespace headframe {

/// Makes or brings up the schema `headframe`, each step in a transaction of its own. incompatible: it is newer;
/// bad_input: the role may not.
Result<void> migrate(PostgresDatabase& database);

/// incompatible: the schema is newer than this server. One that is older, or none yet, is well.
Result<void> schema_is_known(PostgresDatabase& database);

/// The statements that make all tables in a database without any, and `writer` among them; to be run in a transaction.
std::string postgres_tables();

/// Whether there are tables already.
Result<bool> has_tables(PostgresDatabase& database);

}  // namespace headframe
