#include "client/spool/cloud_folder.hpp"

#include <charconv>
#include <cstdio>

#include "client/spool/record_log.hpp"

namespace headframe {

namespace fs = std::filesystem;

Result<void> CloudFolder::find(std::uint64_t last, const std::set<std::uint64_t>& settled) {
  std::error_code fault;
  for (fs::directory_iterator it(directory_, fault), end; !fault && it != end; it.increment(fault)) {
    const std::string name = it->path().filename().string();
    std::uint64_t sequence = 0;
    std::from_chars(name.data(), name.data() + name.size(), sequence);
    std::error_code gone;
    const auto size = it->file_size(gone);
    if (sequence >= 1 && sequence <= last && !settled.contains(sequence) && !gone)
      note(sequence, size);
    else
      fs::remove(it->path(), gone);
  }
  if (fault) return failure(ErrorCode::unavailable, directory_.string() + ": " + fault.message());
  return {};
}

Result<void> CloudFolder::write(std::uint64_t sequence, std::string_view bytes) {
  remove(sequence);
  const fs::path path = path_of(sequence);
  auto written = [&]() -> Result<void> {
    auto file = RecordLog::open(path, [](const Record&) {});
    if (!file) return tl::unexpected(file.error());
    if (auto at = file->append('p', bytes, sync_); !at) return tl::unexpected(at.error());
    if (sync_ && !sync_directory(directory_))
      return failure(ErrorCode::unavailable, path.string() + ": its folder can not be synced");
    return {};
  }();
  std::error_code fault;
  const auto size = fs::file_size(path, fault);
  if (written && !fault)
    note(sequence, size);
  else
    remove(sequence);
  return written;
}

Result<std::string> CloudFolder::read(std::uint64_t sequence) const {
  if (!holds(sequence)) return failure(ErrorCode::not_found, "no cloud " + std::to_string(sequence) + " in the spool");
  auto file = RecordLog::open(path_of(sequence), [](const Record&) {});
  if (!file) return tl::unexpected(file.error());
  return file->read(0);
}

void CloudFolder::remove(std::uint64_t sequence) {
  std::error_code ignored;
  fs::remove(path_of(sequence), ignored);
  const auto held = bytes_of_.find(sequence);
  if (held == bytes_of_.end()) return;
  bytes_ -= held->second;
  bytes_of_.erase(held);
}

std::uint64_t CloudFolder::next(std::uint64_t from) const {
  const auto it = bytes_of_.lower_bound(from);
  return it == bytes_of_.end() ? 0 : it->first;
}

void CloudFolder::note(std::uint64_t sequence, std::uint64_t bytes) {
  bytes_of_[sequence] = bytes;
  bytes_ += bytes;
}

fs::path CloudFolder::path_of(std::uint64_t sequence) const {
  char name[24];
  std::snprintf(name, sizeof name, "%010llu", static_cast<unsigned long long>(sequence));
  return directory_ / name;
}

}  // namespace headframe
