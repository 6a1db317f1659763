#include "server/store/unfinished_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace headframe {

namespace fs = std::filesystem;

Result<void> UnfinishedFile::keep_as(const fs::path& name) {
  std::error_code error;
  fs::rename(path_, name, error);
  const fs::path folder = name.has_parent_path() ? name.parent_path() : fs::path(".");
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool durable = opened >= 0 && ::fsync(opened) == 0;
  if (opened >= 0) ::close(opened);
  if (error || !durable)
    return failure(ErrorCode::unavailable,
                   name.string() + " can not be written: " + (error ? error.message() : std::strerror(errno)));
  kept_ = true;
  return {};
}

void UnfinishedFile::remove() const {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

Result<void> make_private(const fs::path& file) {
  std::ofstream made(file, std::ios::binary | std::ios::trunc);
  std::error_code error;
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write, error);
  if (!made || error)
    return failure(ErrorCode::unavailable, file.string() + " can not be written; is there room, and may it be?");
  return {};
}

}  // namespace headframe
