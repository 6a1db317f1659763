#include "common/security/private_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace headframe {
namespace {

constexpr std::size_t most_bytes = 64 * 1024;

class File {
 public:
  File(const std::filesystem::path& path, int flags) : handle_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~File() {
    if (handle_ >= 0) ::close(handle_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return handle_; }

 private:
  int handle_;
};

tl::unexpected<Error> fault(const std::filesystem::path& path) {
  return failure(errno == ENOENT ? ErrorCode::not_found : ErrorCode::unavailable,
                 path.string() + ": " + std::strerror(errno));
}

bool write_all(int file, std::string_view content) {
  while (!content.empty()) {
    const ssize_t n = ::write(file, content.data(), content.size());
    if (n < 0 && errno != EINTR) return false;
    if (n > 0) content.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

Result<std::string> read_private_file(const std::filesystem::path& path) {
  const File file(path, O_RDONLY);
  struct stat facts {};
  if (file.get() < 0 || ::fstat(file.get(), &facts) != 0) return fault(path);
  if ((facts.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    return failure(ErrorCode::refused,
                   path.string() + " can be used by others; take it from them: chmod 600 " + path.string());
  std::string content(most_bytes + 1, '\0');
  std::size_t size = 0;
  while (size < content.size()) {
    const ssize_t n = ::read(file.get(), content.data() + size, content.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fault(path);
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
  }
  if (size > most_bytes) return failure(ErrorCode::bad_input, path.string() + " is too long for what it should hold");
  content.resize(size);
  return content;
}

Result<void> write_private_file(const std::filesystem::path& path, std::string_view content) {
  auto part = path;
  part += ".part";
  std::error_code ignored;
  std::filesystem::remove(part, ignored);  // left by an earlier crash, with any mode
  {
    const File file(part, O_WRONLY | O_CREAT | O_EXCL);
    if (file.get() < 0 || !write_all(file.get(), content) || ::fsync(file.get()) != 0) return fault(part);
  }
  if (::rename(part.c_str(), path.c_str()) != 0) return fault(path);
  const auto parent = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  const File folder(parent, O_RDONLY | O_DIRECTORY);
  if (folder.get() < 0 || ::fsync(folder.get()) != 0) return fault(parent);
  return {};
}

}  // namespace headframe
