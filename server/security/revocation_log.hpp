#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe {

/// Revocations that the database has not stored yet, in a small file whose blocks are allocated when it is created, so
/// that they can be recorded on a full disk, which refuses the database's writes. Thread safe.
class RevocationLog {
 public:
  static constexpr std::size_t slots = 256;  // that can be used at once; more are refused

  struct Entry {
    std::string robot;
    std::string token_digest;  // 32 bytes, of the revoked credential; empty: it had none
  };

  /// Creates the file (mode 0600) if it does not exist. unavailable: it cannot be created or written; bad_input: it is
  /// not such a file.
  static Result<RevocationLog> open(const std::filesystem::path& file);
  RevocationLog(RevocationLog&& other) noexcept;
  RevocationLog& operator=(RevocationLog&&) = delete;
  ~RevocationLog();

  /// Blocks until the entry is on the disk, and returns its slot. unavailable: all slots are used, or the disk failed.
  Result<std::size_t> add(const Entry& entry);
  /// Call when the database has stored the revocation.
  void remove(std::size_t slot);

  struct Waiting {
    std::size_t slot = 0;
    Entry entry;
  };
  /// Entries left by an earlier server.
  std::vector<Waiting> waiting() const;

 private:
  explicit RevocationLog(int file) : file_(file), taken_(slots, false) {}

  int file_ = -1;
  mutable std::mutex mutex_;
  std::vector<bool> taken_;
};

}  // namespace headframe
