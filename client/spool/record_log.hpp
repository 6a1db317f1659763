#pragma once
// An append-only file of checksummed records, the base of the spool.
//
// A record is: payload length (4 bytes, little endian, 1 to most_record_bytes), CRC-32C of type and payload (4 bytes,
// little endian), type (1 byte), payload. An interrupted write leaves a torn record at the end of the file, which is
// cut off when the file is opened. A fault followed by whole records is damage of another kind and is never cut.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "common/result.hpp"

namespace headframe {

inline constexpr std::size_t most_record_bytes = 32 << 20;

/// Owns a file descriptor and closes it.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~FileDescriptor();
  int get() const { return fd_; }

 private:
  int fd_;
};

std::uint32_t crc32c(std::string_view bytes, std::uint32_t seed = 0);

/// Returns when the names in a directory are on the disk; false if the disk failed.
bool sync_directory(const std::filesystem::path& directory);

struct Record {
  std::uint64_t at_byte = 0;  // for read()
  char type = 0;
  std::string_view payload;  // valid during the call only
};

/// For one process and one thread at a time.
class RecordLog {
 public:
  /// Opens or creates the file, passes every whole record to `each` in order, and cuts off a torn tail (cut_bytes() is
  /// its size). bad_input: damaged in the middle; nothing was changed. unavailable: the disk failed.
  static Result<RecordLog> open(const std::filesystem::path& path, const std::function<void(const Record&)>& each);

  /// Appends one record and returns its position. sync: it is on the disk on return (fdatasync); otherwise it survives
  /// a killed process but not a power cut. After a failed write the file is cut back to its last record.
  Result<std::uint64_t> append(char type, std::string_view payload, bool sync);

  /// The payload of the record at this position, checked again. Thread safe.
  Result<std::string> read(std::uint64_t at_byte) const;

  std::uint64_t bytes() const { return end_; }
  std::uint64_t cut_bytes() const { return cut_bytes_; }

 private:
  RecordLog() = default;
  FileDescriptor file_;
  std::uint64_t end_ = 0;
  std::uint64_t cut_bytes_ = 0;
  std::string path_;
};

}  // namespace headframe
