#pragma once
// Reads the results of merging, and the operator's notes, from their tables.

#include "server/store/database.hpp"
#include "server/store/store.hpp"

namespace headframe {

Result<StoredMerge> read_merge(Database& database);
Result<StoredNotes> read_notes(Database& database);

}  // namespace headframe
