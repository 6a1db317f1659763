#pragma once

#include <filesystem>
#include <memory>

#include "server/store/store.hpp"

namespace headframe {

struct SqliteOptions {
  std::size_t queue_bytes = 256UL * 1024 * 1024;  // of writes that wait; more are refused
  std::uint64_t database_bytes = 0;               // the file's limit, reached like a full disk; 0: none
  int group_ms = 10;                              // writes that come this close share a commit
  int retry_ms = 500;                             // between attempts to write what the disk refuses
};

/// Opens `directory`/headframe.db: WAL, synchronous=FULL, one writer thread with group commit. Creates and locks the
/// directory. unavailable: not writable or in use; incompatible: a newer schema; bad_input: not a headframe database,
/// or its file can not be written.
Result<std::unique_ptr<Store>> open_sqlite_store(const std::filesystem::path& directory,
                                                 const SqliteOptions& options = {});

}  // namespace headframe
