#pragma once

#include "server/store/database.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// Applies one write inside the transaction that the caller has begun. After a failure the caller must roll back. Of a
/// keyframe or cloud `stored` is told how many rows it made, perhaps only when the database settles; none: it was
/// there, or it can not be written.
Result<void> apply(Database& database, const Write& write, const Database::Changed& stored);

/// Of a keyframe or cloud that made no row: success if it is stored as it came; else refused or invalid_argument, and
/// why.
Result<void> why_nothing_changed(Database& database, const Write& write);

/// What a write takes in the queue, roughly.
std::size_t size_bytes(const Write& write);

}  // namespace headframe
