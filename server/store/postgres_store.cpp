#include "server/store/postgres_store.hpp"

#include <algorithm>

#include "server/store/backup.hpp"
#include "server/store/postgres_reader.hpp"
#include "server/store/postgres_schema.hpp"
#include "server/store/postgres_writer.hpp"
#include "server/store/sql_store.hpp"

namespace headframe {
namespace {

constexpr std::chrono::milliseconds first_pause(250), longest_pause(4000);
constexpr std::chrono::milliseconds longest_standby_pause(1000);  // robots may wait for it

Result<std::unique_ptr<PostgresDatabase>> connected(const std::string& url, const std::string& name) {
  auto database = std::make_unique<PostgresDatabase>(url, name);
  if (auto done = database->connect(); !done) return tl::unexpected(done.error());
  return database;
}

Result<std::unique_ptr<PostgresWriterConnection>> open_writer(const std::string& url, const std::string& name,
                                                              std::int64_t mark, PostgresStandby* standby) {
  auto database = connected(url, name);
  if (!database && standby != nullptr && standby->waits())  // it was well before: whatever it is, it may pass
    return failure(ErrorCode::unavailable, database.error().message);
  if (!database) return tl::unexpected(database.error());
  auto done = standby != nullptr ? standby->take(**database) : take_for_one_server(**database);
  if (done) done = migrate(**database);
  if (!done) return tl::unexpected(done.error());
  return PostgresWriterConnection::open(std::move(*database), mark);
}

Result<std::unique_ptr<PostgresWriterConnection>> open_when_there(const std::string& url, const std::string& name,
                                                                  const PostgresOpening& opening) {
  const auto& wait = opening.wait_for_database;
  std::optional<PostgresStandby> standby;
  if (opening.standby) standby.emplace(*opening.standby);
  for (auto pause = first_pause;; pause *= 2) {
    pause = std::min(pause, standby && standby->waits() ? longest_standby_pause : longest_pause);
    auto writer = open_writer(url, name, opening.mark, standby ? &*standby : nullptr);
    const bool is_away = !writer && writer.error().code == ErrorCode::unavailable;
    if (!is_away || !wait || !wait(writer.error(), pause)) return writer;
  }
}

/// Where its disk is PostgreSQL does not say.
Result<std::optional<std::uint64_t>> free_bytes(Database& reader, std::uint64_t clouds_bytes) {
  if (clouds_bytes == 0) return std::nullopt;
  std::uint64_t taken = 0;
  auto read = reader.each("SELECT coalesce(sum(length(encoded)), 0)::bigint FROM clouds",
                          [&](const Row& row) { taken = static_cast<std::uint64_t>(row.integer(0)); });
  if (!read) return tl::unexpected(read.error());
  return clouds_bytes - std::min(clouds_bytes, taken);
}

}  // namespace

Result<std::unique_ptr<Store>> open_postgres_store(const std::filesystem::path& directory, const std::string& url,
                                                   const StoreOptions& options, const PostgresOpening& opening) {
  const auto name = postgres_name(url);
  if (!name) return tl::unexpected(name.error());
  auto owned = DataDirectory::open(directory, DataDirectory::Database::elsewhere);
  if (!owned) return tl::unexpected(owned.error());
  if (std::filesystem::exists(directory / "headframe.db"))
    return failure(ErrorCode::refused, directory.string() + " holds a database of its own, headframe.db, beside " +
                                           *name + ": take it there with --migrate, or move it away");
  remove_unfinished_backups(directory);
  auto writer = open_when_there(url, *name, opening);
  if (!writer) return tl::unexpected(writer.error());
  auto reader = connected(url, *name);
  if (!reader) return tl::unexpected(reader.error());
  return std::make_unique<SqlStore>(SqlStoreParts{
      std::move(*owned), std::make_unique<PostgresReader>(std::move(*reader)), std::move(*writer), options,
      [name = *name](const std::filesystem::path&) -> Result<void> {
        return failure(ErrorCode::refused, "what robots have sent lies in " + name +
                                               ": back that up with pg_dump or pg_basebackup, and the data directory "
                                               "as files");
      },
      [most = options.clouds_bytes](Database& db) { return free_bytes(db, most); }});
}

}  // namespace headframe
