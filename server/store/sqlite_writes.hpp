#pragma once

#include "server/store/sqlite.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// Applies one write inside the transaction that the caller has begun. After a failure the caller must roll back.
Result<void> apply(Database& database, const Write& write);

/// What a write takes in the queue, roughly.
std::size_t size_bytes(const Write& write);

}  // namespace headframe
