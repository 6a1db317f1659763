#pragma once

#include <cstddef>
#include <cstdint>

namespace headframe {

struct StoreOptions {
  std::size_t queue_bytes = 256UL * 1024 * 1024;  // of writes that wait; more are refused
  std::uint64_t database_bytes = 0;               // of SQLite's file: its limit, reached like a full disk; 0: none
  std::uint64_t clouds_bytes = 0;                 // that clouds may take in PostgreSQL, for free_bytes(); 0: not known
  int group_ms = 10;                              // writes that come this close share a commit
  int retry_ms = 500;                             // between attempts to write what the disk refuses ...
  int longest_retry_ms = 500;                     // ... and, doubled each time, at most
};

}  // namespace headframe
