#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace headframe {

/// A file that is being made under a name of its own, and is removed with this unless it was kept.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(std::filesystem::path path) : path_(std::move(path)) { remove(); }
  ~UnfinishedFile() {
    if (!kept_) remove();
  }
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Gives it its name, durably. unavailable: the disk says no.
  Result<void> keep_as(const std::filesystem::path& name);

 private:
  void remove() const;
  std::filesystem::path path_;
  bool kept_ = false;
};

/// An empty file that its owner alone reads and writes; SQLite keeps the mode of a file that is there. unavailable: the
/// disk says no.
Result<void> make_private(const std::filesystem::path& file);

}  // namespace headframe
