#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace headframe {

/// The server's directory, created when it is not there, and locked against a second server as long as this lives. Only
/// its owner can read the database, and the directory itself unless other things are kept in it.
class DataDirectory {
 public:
  enum class Database { here, elsewhere };

  /// unavailable when it can not be created or written, or another server holds it.
  static Result<DataDirectory> open(const std::filesystem::path& path, Database database = Database::here);

  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&& other) noexcept;
  ~DataDirectory();

  const std::filesystem::path& path() const { return path_; }

 private:
  DataDirectory(std::filesystem::path path, int lock, int folder)
      : path_(std::move(path)), lock_(lock), folder_(folder) {}

  std::filesystem::path path_;
  // Servers of before held the lock file alone, which can be removed under a server; the folder can not.
  int lock_ = -1, folder_ = -1;
};

}  // namespace headframe
