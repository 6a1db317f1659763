#pragma once
// Writes that create, end and name sessions.

#include "server/store/database.hpp"
#include "server/store/store.hpp"

namespace headframe {

// They fail like Database::change().
Result<void> put(Database& db, const PutSession& write);
Result<void> put(Database& db, const SplitSession& write);
Result<void> put(Database& db, const CompleteSession& write);
Result<void> put(Database& db, const PutLabel& write);
Result<void> put(Database& db, const PutSessionNote& write);

}  // namespace headframe
