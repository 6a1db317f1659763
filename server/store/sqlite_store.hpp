#pragma once

#include <filesystem>
#include <memory>

#include "server/store/store.hpp"
#include "server/store/store_options.hpp"

namespace headframe {

/// Opens `directory`/headframe.db: WAL, synchronous=FULL, one writer thread with group commit. Creates and locks the
/// directory. unavailable: not writable or in use; incompatible: a newer schema; bad_input: not a headframe database,
/// or its file cannot be written; refused: it was moved to PostgreSQL.
Result<std::unique_ptr<Store>> open_sqlite_store(const std::filesystem::path& directory,
                                                 const StoreOptions& options = {});

}  // namespace headframe
