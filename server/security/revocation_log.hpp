#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe {

/// Revocations that the database has not taken yet, in a small file whose blocks are taken on the disk when it is made:
/// a full disk refuses the database's writes, and these it does not. Thread safe.
class RevocationLog {
 public:
  static constexpr std::size_t slots = 256;  // that may wait at once; more are refused

  struct Entry {
    std::string robot;
    std::string token_digest;  // of the credential that was revoked, 32 bytes; empty: it had none
  };

  /// Makes the file (mode 0600) when it is not there. unavailable: it can not be made or written; bad_input: it is
  /// none.
  static Result<RevocationLog> open(const std::filesystem::path& file);
  RevocationLog(RevocationLog&& other) noexcept;
  RevocationLog& operator=(RevocationLog&&) = delete;
  ~RevocationLog();

  /// On the disk when it returns, which waits for it: the slot. unavailable: all slots wait, or the disk says no.
  Result<std::size_t> add(const Entry& entry);
  /// The database has it.
  void remove(std::size_t slot);

  struct Waiting {
    std::size_t slot = 0;
    Entry entry;
  };
  /// What a server before this one could not hand on.
  std::vector<Waiting> waiting() const;

 private:
  explicit RevocationLog(int file) : file_(file), taken_(slots, false) {}

  int file_ = -1;
  mutable std::mutex mutex_;
  std::vector<bool> taken_;
};

}  // namespace headframe
