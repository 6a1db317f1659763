#include "server/store/sqlite_store.hpp"

#include <algorithm>

#include "server/store/backup.hpp"
#include "server/store/schema.hpp"
#include "server/store/sql_store.hpp"
#include "server/store/sqlite.hpp"

namespace headframe {
namespace {

class SqliteWriterConnection final : public WriterConnection {
 public:
  explicit SqliteWriterConnection(SqliteDatabase database) : database_(std::move(database)) {}
  Database& database() override { return database_; }
  Result<bool> begin() override {
    if (auto begun = database_.execute("BEGIN IMMEDIATE"); !begun) return tl::unexpected(begun.error());
    return true;
  }
  Result<void> commit() override {
    if (auto done = database_.execute("COMMIT"); !done) return done;
    return database_.still_there();
  }
  void rollback() override { (void)database_.execute("ROLLBACK"); }
  bool is_lost() const override { return false; }

 private:
  SqliteDatabase database_;
};

constexpr std::uint64_t page_bytes = 16384;

std::uint64_t most_pages(const StoreOptions& options) { return options.database_bytes / page_bytes + 1; }

/// Includes unused pages of the file, which are written to before it grows.
Result<std::optional<std::uint64_t>> free_bytes(Database& reader, const std::filesystem::path& directory,
                                                const StoreOptions& options) {
  std::uint64_t pages = 0, unused = 0;
  const auto into = [](std::uint64_t& n) {
    return [&n](const Row& row) { n = static_cast<std::uint64_t>(row.integer(0)); };
  };
  auto read = reader.each("PRAGMA page_count", into(pages));
  if (read) read = reader.each("PRAGMA freelist_count", into(unused));
  if (!read) return tl::unexpected(read.error());
  std::error_code error;
  const auto disk = std::filesystem::space(directory, error);
  if (error)
    return failure(ErrorCode::unavailable,
                   "what is free on the disk of " + directory.string() + " is not known: " + error.message());
  std::uint64_t left = disk.available;
  if (options.database_bytes > 0)
    left = std::min(left, (most_pages(options) - std::min(pages, most_pages(options))) * page_bytes);
  return left + unused * page_bytes;
}

}  // namespace

Result<std::unique_ptr<Store>> open_sqlite_store(const std::filesystem::path& directory, const StoreOptions& options) {
  if (!std::filesystem::exists(directory / "headframe.db") && std::filesystem::exists(directory / "headframe.db.moved"))
    return failure(ErrorCode::refused, "the database of " + directory.string() +
                                           " was taken to PostgreSQL (what was here is headframe.db.moved): give its "
                                           "url in [store], or take it back with --migrate");
  auto owned = DataDirectory::open(directory);
  if (!owned) return tl::unexpected(owned.error());
  remove_unfinished_backups(directory);
  const std::string path = (directory / "headframe.db").string();
  auto writer = SqliteDatabase::open(path);
  if (!writer) return tl::unexpected(writer.error());
  std::string pragmas =
      "PRAGMA page_size=16384; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON;";
  if (options.database_bytes > 0) pragmas += "PRAGMA max_page_count=" + std::to_string(most_pages(options)) + ";";
  auto done = writer->execute(pragmas);
  if (done) done = migrate(*writer);
  if (!done) return failure(done.error().code, directory.string() + ": " + done.error().message);
  auto reader = SqliteDatabase::open(path);
  if (!reader) return tl::unexpected(reader.error());
  return std::make_unique<SqlStore>(
      SqlStoreParts{std::move(*owned), std::make_unique<SqliteDatabase>(std::move(*reader)),
                    std::make_unique<SqliteWriterConnection>(std::move(*writer)), options,
                    [directory](const std::filesystem::path& file) { return write_backup(directory, file); },
                    [directory, options](Database& db) { return free_bytes(db, directory, options); }});
}

}  // namespace headframe
