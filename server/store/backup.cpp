#include "server/store/backup.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <vector>

#include "common/security/private_file.hpp"
#include "server/store/data_directory.hpp"
#include "server/store/schema.hpp"
#include "server/store/sqlite.hpp"
#include "server/store/unfinished_file.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

constexpr const char* database_name = "headframe.db";
constexpr std::string_view notes_name = "notes.jsonl";  // may be larger than the others
constexpr std::array<std::string_view, 5> private_files{"identity.pem", "operator.token", "operators.json", "revoked",
                                                        notes_name};

struct PrivateFile {
  std::string name, content;
};

/// Copies the whole database in the state seen by one transaction.
Result<void> copy_database(const fs::path& from, const fs::path& to) {
  auto database = SqliteDatabase::open(from.string());
  if (!database) return tl::unexpected(database.error());
  if (auto made = make_private(to); !made) return made;
  return database->run("VACUUM INTO ?", to.string());
}

/// The file may end with an incomplete line that is being written; readers skip such a line.
Result<std::string> read_notes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return failure(ErrorCode::not_found, "there is no " + file.string());
  return std::string(std::istreambuf_iterator<char>(in), {});
}

Result<void> put_private_files(SqliteDatabase& backup, const fs::path& directory) {
  auto done = backup.execute("CREATE TABLE private_files (name TEXT PRIMARY KEY, content BLOB NOT NULL)");
  for (const std::string_view name : private_files) {
    if (!done) return done;
    const auto content = name == notes_name ? read_notes(directory / name) : read_private_file(directory / name);
    if (content)
      done = backup.run("INSERT INTO private_files VALUES (?,?)", std::string(name), Blob{*content});
    else if (content.error().code != ErrorCode::not_found)
      return tl::unexpected(content.error());
  }
  return done;
}

tl::unexpected<Error> no_backup(const fs::path& file, const std::string& why) {
  return failure(ErrorCode::bad_input,
                 file.string() + " is no whole backup: " + why + "; give a file that headframe backup has written");
}

/// Takes the private files out of the backup's database.
Result<std::vector<PrivateFile>> take_private_files(SqliteDatabase& backup) {
  std::vector<PrivateFile> files;
  auto done = backup.each("SELECT name, content FROM private_files", [&](const Row& row) {
    files.push_back({row.text(0), std::string(row.blob(1))});
  });
  if (done) done = backup.execute("DROP TABLE private_files");
  if (!done) return failure(ErrorCode::bad_input, "it lacks the table of private files");
  for (const PrivateFile& file : files)
    if (std::find(private_files.begin(), private_files.end(), file.name) == private_files.end())
      return failure(ErrorCode::bad_input, "it holds a file that no server keeps");
  return files;
}

Result<void> check_whole(SqliteDatabase& backup) {
  std::string verdict;
  int version = 0;
  auto read = backup.each("PRAGMA integrity_check(1)", [&](const Row& row) { verdict = row.text(0); });
  if (read)
    read = backup.each("PRAGMA user_version", [&](const Row& row) { version = static_cast<int>(row.integer(0)); });
  if (!read) return failure(ErrorCode::bad_input, "it is damaged, or no database at all");
  std::replace(verdict.begin(), verdict.end(), '\n', ' ');
  if (verdict != "ok") return failure(ErrorCode::bad_input, verdict);
  if (version > schema_version())
    return failure(ErrorCode::incompatible, "a newer headframe-server wrote it; use that one");
  return {};
}

}  // namespace

Result<void> write_backup(const fs::path& directory, const fs::path& file) {
  const fs::path database = directory / database_name;
  if (!fs::exists(database)) return failure(ErrorCode::not_found, "there is no database in " + directory.string());
  UnfinishedFile part(file.string() + ".part");
  if (auto done = copy_database(database, part.path()); !done) return done;
  {
    auto backup = SqliteDatabase::open(part.path().string());
    if (!backup) return tl::unexpected(backup.error());
    if (auto done = put_private_files(*backup, directory); !done) return done;
  }
  return part.keep_as(file);
}

void remove_unfinished_backups(const fs::path& directory) {
  std::error_code ignored;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(directory, ignored))
    if (entry.path().filename().string().starts_with("headframe.backup-")) left.push_back(entry.path());
  for (const fs::path& file : left) fs::remove(file, ignored);
}

Result<void> restore_backup(const fs::path& file, const fs::path& directory) {
  if (!fs::exists(file)) return failure(ErrorCode::not_found, "there is no file " + file.string());
  if (fs::exists(directory / database_name))
    return failure(ErrorCode::refused,
                   "there is a database in " + directory.string() +
                       " already, and a backup replaces none: give another --data, or move that one away");
  std::error_code error;
  fs::create_directories(directory, error);
  UnfinishedFile part(directory / "headframe.db.restored");
  if (auto made = make_private(part.path()); !made) return made;
  if (!fs::copy_file(file, part.path(), fs::copy_options::overwrite_existing, error))
    return failure(ErrorCode::unavailable,
                   file.string() + " can not be copied to " + directory.string() + ": " + error.message());
  std::vector<PrivateFile> files;
  {
    auto backup = SqliteDatabase::open(part.path().string());
    if (!backup) return no_backup(file, backup.error().message);
    if (auto whole = check_whole(*backup); !whole) {
      if (whole.error().code == ErrorCode::incompatible)
        return failure(ErrorCode::incompatible, file.string() + ": " + whole.error().message);
      return no_backup(file, whole.error().message);
    }
    auto taken = take_private_files(*backup);
    if (!taken) return no_backup(file, taken.error().message);
    files = std::move(*taken);
  }
  for (const PrivateFile& one : files)
    if (auto written = write_private_file(directory / one.name, one.content); !written) return written;
  return part.keep_as(directory / database_name);
}

}  // namespace headframe
