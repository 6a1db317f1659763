#pragma once

#include "server/store/database.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// Applies one write in the transaction that the caller has begun. After a failure the caller must roll back. For a
/// keyframe or cloud, `stored` is called with the number of rows created, possibly only when the database settles; 0:
/// it was there, or cannot be written.
Result<void> apply(Database& database, const Write& write, const Database::Changed& stored);

/// For a keyframe or cloud that created no row: success if the same one is stored; else refused or invalid_argument,
/// with the reason.
Result<void> why_nothing_changed(Database& database, const Write& write);

/// Approximate size of a write in the queue.
std::size_t size_bytes(const Write& write);

}  // namespace headframe
