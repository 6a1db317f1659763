#include "server/store/data_directory.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace headframe {
namespace {

namespace fs = std::filesystem;

/// The database and SQLite's files beside it.
constexpr std::array database_files{"headframe.db", "headframe.db-wal", "headframe.db-shm", "headframe.lock"};

constexpr auto others = fs::perms::group_all | fs::perms::others_all;

/// A folder that is empty or contains a database is the server's own. A shared one (a home, /tmp) keeps its mode.
bool looks_our_own(const fs::path& path) {
  std::error_code error;
  const bool shared = (fs::status(path, error).permissions() & fs::perms::sticky_bit) != fs::perms::none;
  return !shared && (fs::is_empty(path, error) || fs::exists(path / "headframe.db", error));
}

/// Other users of the machine must not read what robots have mapped. SQLite gives its other files the mode of the
/// database, so that is created, empty, before SQLite opens it.
void take_from_others(const fs::path& path, bool is_our_own, DataDirectory::Database database) {
  std::error_code ignored;
  if (is_our_own) fs::permissions(path, others, fs::perm_options::remove, ignored);
  const bool is_here = database == DataDirectory::Database::here;
  const int made = is_here ? ::open((path / "headframe.db").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600) : -1;
  if (made >= 0) ::close(made);
  for (const char* name : database_files) fs::permissions(path / name, others, fs::perm_options::remove, ignored);
}

/// Whether another process has locked it; otherwise this process now has. If a file system cannot lock folders, it
/// counts as free.
bool is_taken(int file) { return ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

}  // namespace

Result<DataDirectory> DataDirectory::open(const std::filesystem::path& path, Database database) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error)
    return failure(ErrorCode::unavailable, "data directory " + path.string() +
                                               " can not be created: " + error.message() + "; choose another --data");
  const bool is_our_own = looks_our_own(path);
  const int lock = ::open((path / "headframe.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DataDirectory locked(path, lock, folder);
  if (lock < 0 || folder < 0)
    return failure(ErrorCode::unavailable, "data directory " + path.string() + " can not be written: " +
                                               std::strerror(errno) + "; choose another --data");
  if (is_taken(lock) || is_taken(folder))
    return failure(ErrorCode::unavailable, "data directory " + path.string() +
                                               " is in use by another headframe-server; stop it or choose another "
                                               "--data");
  take_from_others(path, is_our_own, database);
  return locked;
}

DataDirectory::DataDirectory(DataDirectory&& other) noexcept
    : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)), folder_(std::exchange(other.folder_, -1)) {}

DataDirectory& DataDirectory::operator=(DataDirectory&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(lock_, other.lock_);
  std::swap(folder_, other.folder_);
  return *this;
}

DataDirectory::~DataDirectory() {
  for (const int file : {lock_, folder_})
    if (file >= 0) ::close(file);
}

}  // namespace headframe
