#include "server/security/revocation_log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

namespace headframe {
namespace {

constexpr std::size_t slot_bytes = 256, name_at = 34, most_name = slot_bytes - name_at;
constexpr auto file_bytes = static_cast<off_t>(RevocationLog::slots * slot_bytes);

/// Length of the name (0: the slot is free), length of the digest, the digest, the name.
using Slot = std::array<char, slot_bytes>;

off_t offset_of(std::size_t slot) { return static_cast<off_t>(slot * slot_bytes); }

std::optional<RevocationLog::Entry> entry_of(const Slot& slot) {
  const auto name = static_cast<unsigned char>(slot[0]), digest = static_cast<unsigned char>(slot[1]);
  if (name == 0 || name > most_name || digest > name_at - 2) return std::nullopt;
  return RevocationLog::Entry{{slot.data() + name_at, name}, {slot.data() + 2, digest}};
}

bool read(int file, std::size_t slot, Slot& out) {
  return ::pread(file, out.data(), out.size(), offset_of(slot)) == static_cast<ssize_t>(out.size());
}

bool write(int file, std::size_t slot, const Slot& content) {
  return ::pwrite(file, content.data(), content.size(), offset_of(slot)) == static_cast<ssize_t>(content.size());
}

}  // namespace

Result<RevocationLog> RevocationLog::open(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  struct stat facts {};
  const int fault = file < 0 || ::fstat(file, &facts) != 0 ? errno : 0;
  RevocationLog log(file);
  const int refused = fault != 0 ? fault : facts.st_size < file_bytes ? ::posix_fallocate(file, 0, file_bytes) : 0;
  if (refused != 0)
    return failure(ErrorCode::unavailable, path.string() + " can not be written: " + std::strerror(refused));
  if (facts.st_size > file_bytes) return failure(ErrorCode::bad_input, path.string() + " is no list of revocations");
  for (const Waiting& waiting : log.waiting()) log.taken_[waiting.slot] = true;
  return log;
}

RevocationLog::RevocationLog(RevocationLog&& other) noexcept
    : file_(std::exchange(other.file_, -1)), taken_(std::move(other.taken_)) {}

RevocationLog::~RevocationLog() {
  if (file_ >= 0) ::close(file_);
}

Result<std::size_t> RevocationLog::add(const Entry& entry) {
  const std::lock_guard lock(mutex_);
  const auto free = std::find(taken_.begin(), taken_.end(), false);
  if (free == taken_.end() || entry.robot.empty() || entry.robot.size() > most_name ||
      entry.token_digest.size() > name_at - 2)
    return failure(ErrorCode::unavailable, "there is no room for another revocation until the disk has some");
  const auto slot = static_cast<std::size_t>(free - taken_.begin());
  Slot content{};
  content[0] = static_cast<char>(entry.robot.size());
  content[1] = static_cast<char>(entry.token_digest.size());
  std::copy(entry.token_digest.begin(), entry.token_digest.end(), content.begin() + 2);
  std::copy(entry.robot.begin(), entry.robot.end(), content.begin() + name_at);
  if (!write(file_, slot, content) || ::fdatasync(file_) != 0)
    return failure(ErrorCode::unavailable, std::string("a revocation can not be written: ") + std::strerror(errno));
  *free = true;
  return slot;
}

/// Not synced: if it comes back after a power cut, the revocation is only repeated.
void RevocationLog::remove(std::size_t slot) {
  const std::lock_guard lock(mutex_);
  if (write(file_, slot, {})) taken_[slot] = false;
}

std::vector<RevocationLog::Waiting> RevocationLog::waiting() const {
  const std::lock_guard lock(mutex_);
  std::vector<Waiting> all;
  Slot content{};
  for (std::size_t slot = 0; slot < slots; ++slot)
    if (read(file_, slot, content))
      if (auto entry = entry_of(content)) all.push_back({slot, std::move(*entry)});
  return all;
}

}  // namespace headframe
