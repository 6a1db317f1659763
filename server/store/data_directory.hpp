#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace headframe {

/// The server's directory, created if it does not exist, and locked against a second server while this object exists.
/// Only its owner can read the database, and also the directory itself unless it has other content.
class DataDirectory {
 public:
  enum class Database { here, elsewhere };

  /// unavailable: it cannot be created or written, or another server has locked it.
  static Result<DataDirectory> open(const std::filesystem::path& path, Database database = Database::here);

  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&& other) noexcept;
  ~DataDirectory();

  const std::filesystem::path& path() const { return path_; }

 private:
  DataDirectory(std::filesystem::path path, int lock, int folder)
      : path_(std::move(path)), lock_(lock), folder_(folder) {}

  std::filesystem::path path_;
  // Earlier servers locked only the lock file, which can be removed while a server runs; the folder cannot.
  int lock_ = -1, folder_ = -1;
};

}  // namespace headframe
