#include "client/spool/record_log.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace headframe {
namespace {

constexpr std::size_t header_bytes = 9;

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? c >> 1 ^ 0x82f63b78U : c >> 1;
    table[i] = c;
  }
  return table;
}

void put_u32(std::string& out, std::uint32_t v) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>(v >> shift & 0xff));
}

std::uint32_t get_u32(const char* p) {
  const auto* b = reinterpret_cast<const unsigned char*>(p);
  return std::uint32_t{b[0]} | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
}

/// Size of the whole, intact record at the start of `bytes`; 0: there is none.
std::size_t whole_record(std::string_view bytes) {
  if (bytes.size() <= header_bytes) return 0;
  const std::size_t length = get_u32(bytes.data());
  if (length < 1 || length > most_record_bytes || length > bytes.size() - header_bytes) return 0;
  if (crc32c(bytes.substr(8, 1 + length)) != get_u32(bytes.data() + 4)) return 0;
  return header_bytes + length;
}

/// Whether the bytes may be a record whose writing was interrupted: they start like one, or are the zeros that a file
/// system leaves where it had only allocated space.
bool may_be_torn(std::string_view bytes) {
  if (bytes.size() < header_bytes) return true;
  const std::size_t length = get_u32(bytes.data());
  return (length >= 1 && length <= most_record_bytes) || bytes.find_first_not_of('\0') == std::string_view::npos;
}

tl::unexpected<Error> disk_fault(const std::string& path, const char* what) {
  return failure(ErrorCode::unavailable, path + ": " + what + ": " + std::strerror(errno));
}

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto n = ::write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

bool read_all(int file, std::uint64_t at_byte, std::string& out) {
  for (std::size_t done = 0; done < out.size();) {
    const auto n = ::pread(file, out.data() + done, out.size() - done, static_cast<off_t>(at_byte + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

bool sync_directory(const std::filesystem::path& directory) {
  const FileDescriptor file(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return file.get() >= 0 && ::fsync(file.get()) == 0;
}

std::uint32_t crc32c(std::string_view bytes, std::uint32_t seed) {
  static constexpr auto table = crc_table();
  std::uint32_t c = ~seed;
  for (const char b : bytes) c = table[(c ^ static_cast<unsigned char>(b)) & 0xff] ^ c >> 8;
  return ~c;
}

Result<RecordLog> RecordLog::open(const std::filesystem::path& path, const std::function<void(const Record&)>& each) {
  RecordLog log;
  log.path_ = path.string();
  log.file_ = FileDescriptor(::open(log.path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  struct stat status {};
  if (log.file_.get() < 0 || ::fstat(log.file_.get(), &status) != 0) return disk_fault(log.path_, "can not be opened");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  if (!read_all(log.file_.get(), 0, bytes)) return disk_fault(log.path_, "can not be read");

  std::string_view rest(bytes);
  while (const std::size_t n = whole_record(rest)) {
    each({log.end_, rest[8], rest.substr(header_bytes, n - header_bytes)});
    log.end_ += n;
    rest.remove_prefix(n);
  }
  for (std::size_t i = 1; i < rest.size(); ++i)
    if (whole_record(rest.substr(i)) != 0)
      return failure(ErrorCode::bad_input, log.path_ + ": damaged at byte " + std::to_string(log.end_) +
                                               ", whole records follow at byte " + std::to_string(log.end_ + i) +
                                               "; keep the folder for repair and start with another one");
  if (log.end_ == 0 && !may_be_torn(rest))
    return failure(ErrorCode::bad_input, log.path_ +
                                             ": no spool has written this; keep the folder for repair and start "
                                             "with another one");
  log.cut_bytes_ = rest.size();
  if (!rest.empty() && ::ftruncate(log.file_.get(), static_cast<off_t>(log.end_)) != 0)
    return disk_fault(log.path_, "the torn end can not be cut off");
  return log;
}

Result<std::uint64_t> RecordLog::append(char type, std::string_view payload, bool sync) {
  if (payload.empty() || payload.size() > most_record_bytes)
    return failure(ErrorCode::internal, path_ + ": a record of " + std::to_string(payload.size()) + " bytes");
  std::string record;
  record.reserve(header_bytes + payload.size());
  put_u32(record, static_cast<std::uint32_t>(payload.size()));
  put_u32(record, crc32c(payload, crc32c({&type, 1})));
  record.push_back(type);
  record.append(payload);
  if (!write_all(file_.get(), record) || (sync && ::fdatasync(file_.get()) != 0)) {
    auto fault = disk_fault(path_, "can not be written");
    if (::ftruncate(file_.get(), static_cast<off_t>(end_)) != 0) fault = disk_fault(path_, "can not be cut back");
    return fault;
  }
  return std::exchange(end_, end_ + record.size());
}

Result<std::string> RecordLog::read(std::uint64_t at_byte) const {
  std::string record(header_bytes, '\0');
  if (!read_all(file_.get(), at_byte, record)) return disk_fault(path_, "can not be read");
  const std::size_t length = get_u32(record.data());
  if (length < 1 || length > most_record_bytes)
    return failure(ErrorCode::bad_input, path_ + ": damaged at byte " + std::to_string(at_byte));
  record.resize(header_bytes + length);
  if (!read_all(file_.get(), at_byte, record) || whole_record(record) == 0)
    return failure(ErrorCode::bad_input, path_ + ": damaged at byte " + std::to_string(at_byte));
  return record.substr(header_bytes);
}

}  // namespace headframe
