#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace headframe {

/// A file under a temporary name while it is being made; removed by the destructor unless keep_as() was called.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(std::filesystem::path path) : path_(std::move(path)) { remove(); }
  ~UnfinishedFile() {
    if (!kept_) remove();
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Renames it, durably. unavailable: the disk failed.
  Result<void> keep_as(const std::filesystem::path& name);

 private:
  void remove() const;
  std::filesystem::path path_;
  bool kept_ = false;
};

/// Creates an empty file that only its owner can read and write; SQLite keeps the mode of an existing file.
/// unavailable: the disk failed.
Result<void> make_private(const std::filesystem::path& file);

}  // namespace headframe
