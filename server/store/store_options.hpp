#pragma once

#include <cstddef>
#include <cstdint>

namespace headframe {

struct StoreOptions {
  std::size_t queue_bytes = 256UL * 1024 * 1024;  // limit of waiting writes; further ones are refused
  std::uint64_t database_bytes = 0;               // size limit of SQLite's file, which acts like a full disk; 0: none
  std::uint64_t clouds_bytes = 0;                 // space for clouds in PostgreSQL, for free_bytes(); 0: unknown
  int group_ms = 10;                              // writes that arrive within this time share a commit
  int retry_ms = 500;                             // first pause before what the disk refused is written again
  int longest_retry_ms = 500;                     // the pause doubles each time, up to this
};

}  // namespace headframe
