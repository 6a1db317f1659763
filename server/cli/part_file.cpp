#include "server/cli/part_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

namespace headframe {
namespace {

std::array<char, PATH_MAX> part_name{};  // what a signal removes; empty: nothing

void remove_part(int signal) {
  if (part_name[0] != 0) ::unlink(part_name.data());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void watch_signals(const std::string& part) {
  part_name.fill(0);
  std::copy_n(part.begin(), std::min(part.size(), part_name.size() - 1), part_name.begin());
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, part.empty() ? SIG_DFL : remove_part);
}

tl::unexpected<Error> cannot_write(const std::string& path, const std::string& why) {
  return failure(ErrorCode::unavailable, "cannot write " + path + ": " + why);
}

}  // namespace

Result<PartFile> PartFile::create(const std::string& path, bool secret) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return cannot_write(path, "it is a directory");
  const std::string part = path + ".part";
  if (part.size() >= part_name.size()) return cannot_write(path, "its name is too long");
  if (secret) ::unlink(part.c_str());  // it may be there with another mode
  const int opened = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, secret ? 0600 : 0666);
  std::FILE* file = opened < 0 ? nullptr : ::fdopen(opened, "wb");
  if (!file) return cannot_write(path, std::strerror(errno));
  watch_signals(part);
  return PartFile(path, file);
}

PartFile::PartFile(PartFile&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, nullptr)) {}

PartFile::~PartFile() {
  if (!file_) return;
  std::fclose(file_);
  ::unlink((path_ + ".part").c_str());
  watch_signals("");
}

tl::unexpected<Error> PartFile::fault() const { return cannot_write(path_, std::strerror(errno)); }

Result<void> PartFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) return fault();
  return {};
}

Result<void> PartFile::commit() {
  if (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0) return fault();
  if (std::rename((path_ + ".part").c_str(), path_.c_str()) != 0) return fault();
  watch_signals("");
  std::fclose(std::exchange(file_, nullptr));
  return {};
}

}  // namespace headframe
