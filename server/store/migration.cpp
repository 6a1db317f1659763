#include "server/store/migration.hpp"

#include "server/store/data_directory.hpp"
#include "server/store/postgres_schema.hpp"
#include "server/store/postgres_writer.hpp"
#include "server/store/schema.hpp"
#include "server/store/sqlite.hpp"
#include "server/store/unfinished_file.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

Result<Migrated> copy_and_compare(Database& from, Database& to, const TableProgress& progress) {
  const auto sent = copy_tables(from, to, progress);
  if (!sent) return tl::unexpected(sent.error());
  const auto arrived = sum_tables(to, [&](std::string_view table, std::uint64_t rows, std::uint64_t of) {
    progress("comparing " + std::string(table), rows, of);
  });
  if (!arrived) return tl::unexpected(arrived.error());
  Migrated all;
  for (const auto& [table, sum] : *sent) {
    if (arrived->at(table) != sum)
      return failure(ErrorCode::internal, "table " + table +
                                              " is not the same where it went: " + std::to_string(sum.rows) +
                                              " rows were sent, " + std::to_string(arrived->at(table).rows) +
                                              " are there; nothing was changed");
    ++all.tables;
    all.rows += sum.rows;
  }
  return all;
}

Result<std::unique_ptr<PostgresDatabase>> taken_postgres(const std::string& url) {
  const auto name = postgres_name(url);
  if (!name) return tl::unexpected(name.error());
  auto database = std::make_unique<PostgresDatabase>(url, *name);
  auto done = database->connect();
  if (done) done = take_for_one_server(*database);
  if (!done) return tl::unexpected(done.error());
  return database;
}

/// Creates the tables. Replaces existing ones without rows, as left by a server that was started but never used.
Result<void> make_empty_tables(PostgresDatabase& to) {
  const auto there = has_tables(to);
  if (!there) return tl::unexpected(there.error());
  if (*there) {
    const auto sums = sum_tables(to, [](auto, auto, auto) {});
    if (!sums) return tl::unexpected(sums.error());
    for (const auto& [table, sum] : *sums)
      if (sum.rows > 0)
        return failure(ErrorCode::refused, to.name() +
                                               " holds a base station's database already, and a migration "
                                               "replaces none: give another, or drop its schema headframe");
  }
  return to.execute((*there ? "DROP SCHEMA headframe CASCADE;" : "") + postgres_tables());
}

Result<Migrated> fill(SqliteDatabase& from, PostgresDatabase& to, const TableProgress& progress) {
  auto done = to.execute("BEGIN");
  if (done) done = make_empty_tables(to);
  if (!done) return tl::unexpected(done.error());
  auto migrated = copy_and_compare(from, to, progress);
  if (!migrated) return migrated;
  done = to.execute("SELECT setval(pg_get_serial_sequence('merge_order', 'step'), max(step)) FROM merge_order");
  if (done) done = to.execute("COMMIT");
  if (!done) return tl::unexpected(done.error());
  return migrated;
}

}  // namespace

Result<Migrated> migrate_to_postgres(const fs::path& directory, const std::string& url, const TableProgress& progress) {
  const fs::path file = directory / "headframe.db";
  if (!fs::exists(file)) return failure(ErrorCode::not_found, "there is no database in " + directory.string());
  const auto owned = DataDirectory::open(directory);
  if (!owned) return tl::unexpected(owned.error());
  auto to = taken_postgres(url);
  if (!to) return tl::unexpected(to.error());
  Result<Migrated> migrated;
  {
    auto from = SqliteDatabase::open(file.string());
    if (!from) return tl::unexpected(from.error());
    auto ready = migrate(*from);
    if (ready) ready = from->execute("PRAGMA journal_mode=DELETE");  // afterwards the file alone is the database
    if (!ready) return tl::unexpected(ready.error());
    migrated = fill(*from, **to, progress);
    if (!migrated) return migrated;
  }
  std::error_code error;
  fs::rename(file, directory / "headframe.db.moved", error);
  if (error)
    return failure(ErrorCode::unavailable, "all is in " + (*to)->name() + ", but " + file.string() +
                                               " can not be renamed: move it away before a server is started there");
  return migrated;
}

Result<Migrated> migrate_to_sqlite(const std::string& url, const fs::path& directory, const TableProgress& progress) {
  const fs::path file = directory / "headframe.db";
  const auto owned = DataDirectory::open(directory, DataDirectory::Database::elsewhere);
  if (!owned) return tl::unexpected(owned.error());
  if (fs::exists(file))
    return failure(ErrorCode::refused, "there is a database in " + directory.string() +
                                           " already, and a migration replaces none: move it away");
  auto from = taken_postgres(url);
  if (!from) return tl::unexpected(from.error());
  const auto there = has_tables(**from);
  if (!there) return tl::unexpected(there.error());
  if (!*there) return failure(ErrorCode::not_found, (*from)->name() + " holds no base station's database");
  if (auto ready = migrate(**from); !ready) return tl::unexpected(ready.error());
  UnfinishedFile part(directory / "headframe.db.migrated");
  if (auto made = make_private(part.path()); !made) return tl::unexpected(made.error());
  Result<Migrated> migrated;
  {
    auto to = SqliteDatabase::open(part.path().string());
    if (!to) return tl::unexpected(to.error());
    auto done = to->execute("PRAGMA page_size=16384; PRAGMA synchronous=FULL;");
    if (done) done = migrate(*to);
    if (done) done = to->execute("BEGIN");
    if (!done) return tl::unexpected(done.error());
    migrated = copy_and_compare(**from, *to, progress);
    if (!migrated) return migrated;
    if (done = to->execute("COMMIT"); !done) return tl::unexpected(done.error());
  }
  if (auto kept = part.keep_as(file); !kept) return tl::unexpected(kept.error());
  return migrated;
}

}  // namespace headframe
