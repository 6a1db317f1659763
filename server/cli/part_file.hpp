#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// A file that appears under its name only when it is whole: written as FILE.part, renamed by commit(), removed
/// otherwise, also when SIGINT, SIGTERM or SIGHUP ends the process. One at a time.
class PartFile {
 public:
  /// unavailable: the file can not be written, with the reason. secret: nobody but its owner may read it.
  static Result<PartFile> create(const std::string& path, bool secret = false);
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();

  Result<void> write(std::string_view bytes);
  /// On disk under its own name; write nothing after it.
  Result<void> commit();

 private:
  PartFile(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}
  tl::unexpected<Error> fault() const;

  std::string path_;
  std::FILE* file_;
};

}  // namespace headframe
