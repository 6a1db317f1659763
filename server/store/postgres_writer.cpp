#include "server/store/postgres_writer.hpp"

#include <chrono>
#include <random>
#include <thread>

namespace headframe {
namespace {

constexpr std::int64_t lock_key = 0x6865616466726d65;  // "headfrme"

constexpr auto look_again = std::chrono::milliseconds(100);
constexpr int most_looks = 300;
constexpr int idle_looks = 3;  // so often in a row the connection of a dead server is never seen idle

struct Holder {
  std::string who;
  bool is_idle = false;
};

/// Who has the lock, as far as the role may see it.
Holder holder(PostgresDatabase& database) {
  Holder found;
  (void)database.each(
      "SELECT ', connected from ' || coalesce(host(client_addr), 'the same machine') || ' since ' ||"
      " to_char(backend_start, 'YYYY-MM-DD HH24:MI:SS TZ'), coalesce(state LIKE 'idle%', true) FROM pg_locks"
      " JOIN pg_stat_activity USING (pid) WHERE locktype = 'advisory' AND granted AND"
      " (classid::bigint << 32 | objid::bigint) = ? AND"
      " pg_locks.database = (SELECT oid FROM pg_database WHERE datname = current_database())",
      [&](const Row& row) {
        found = {row.text(0), row.integer(1) != 0};
      },
      lock_key);
  return found;
}

std::string in_use_by(const PostgresDatabase& database, const Holder& other) {
  return database.name() + " is in use by another headframe-server" + other.who;
}

}  // namespace

Result<bool> try_to_take(PostgresDatabase& database) {
  bool taken = false;
  auto asked = database.each(
      "SELECT pg_try_advisory_lock(?)", [&](const Row& row) { taken = row.integer(0) != 0; }, lock_key);
  if (!asked) return tl::unexpected(asked.error());
  return taken;
}

std::string in_use(PostgresDatabase& database) { return in_use_by(database, holder(database)); }

Result<void> take_for_one_server(PostgresDatabase& database, bool once) {
  Holder other;
  for (int looks = 0, idle = 0; looks < most_looks && idle < idle_looks; ++looks) {
    const auto taken = try_to_take(database);
    if (!taken) return tl::unexpected(taken.error());
    if (*taken) return {};
    other = holder(database);
    idle = other.is_idle ? idle + 1 : 0;
    if (once) break;
    std::this_thread::sleep_for(look_again);
  }
  return failure(ErrorCode::refused, in_use_by(database, other) +
                                         "; stop that one, give this one a database of its own, or let it wait with "
                                         "standby = true in [store]");
}

std::int64_t random_mark() {
  std::random_device random;
  return static_cast<std::int64_t>((std::uint64_t{random()} << 32U) | random());
}

Result<std::unique_ptr<PostgresWriterConnection>> PostgresWriterConnection::open(
    std::unique_ptr<PostgresDatabase> database, std::int64_t mark) {
  std::unique_ptr<PostgresWriterConnection> made(new PostgresWriterConnection(std::move(database)));
  made->owner_ = mark != 0 ? mark : random_mark();
  auto done = made->database_->run_counted(
      "UPDATE writer SET owner=?, commits=0", [&](std::uint64_t rows) { made->counted_ = rows; }, made->owner_);
  if (done) done = made->database_->settle();
  if (!done) return tl::unexpected(done.error());
  if (made->counted_ != 1)
    return failure(ErrorCode::bad_input, made->database_->name() +
                                             ": the row of table headframe.writer is gone; was "
                                             "the database restored in part?");
  return made;
}

Result<void> PostgresWriterConnection::reconnect() {
  auto done = database_->connect();
  if (done) done = take_for_one_server(*database_, true);
  if (done) return done;
  const Error why = done.error();
  // A server that has taken over is known by its mark; without one, the lock is that of our own lost connection.
  if (why.code == ErrorCode::refused)
    if (const auto committed = found_committed(); !committed && committed.error().code == ErrorCode::bad_input)
      return tl::unexpected(committed.error());
  return failure(ErrorCode::unavailable, why.message);
}

/// Whether the commit in doubt happened. bad_input: this server may not write any more.
Result<bool> PostgresWriterConnection::found_committed() {
  std::int64_t owner = 0, commits = 0;
  auto read = database_->each("SELECT owner, commits FROM writer",
                              [&](const Row& row) { owner = row.integer(0), commits = row.integer(1); });
  if (!read) return tl::unexpected(read.error());
  if (owner != owner_)
    return failure(ErrorCode::bad_input, database_->name() +
                                             ": another headframe-server has taken the database over; "
                                             "stop that one before this one is started anew");
  if (commits == commits_) return false;
  if (in_doubt_ && commits == commits_ + 1) return true;
  return failure(ErrorCode::bad_input, database_->name() + " is not as this server left it: of " +
                                           std::to_string(commits_) + " commits that were acknowledged it has " +
                                           std::to_string(commits) +
                                           "; was a standby promoted that lagged behind, or a backup restored?");
}

/// On a new connection: whether the commit in doubt happened.
Result<bool> PostgresWriterConnection::come_back() {
  has_it_ = false;
  if (auto there = reconnect(); !there) return tl::unexpected(there.error());
  auto committed = found_committed();
  if (!committed) return committed;
  has_it_ = true;
  in_doubt_ = false;
  commits_ += *committed ? 1 : 0;
  return committed;
}

Result<void> PostgresWriterConnection::look_after() {
  if (!is_lost()) return database_->each("SELECT 1", [](const Row&) {});
  const auto back = come_back();
  return back ? Result<void>() : tl::unexpected(back.error());
}

Result<bool> PostgresWriterConnection::begin() {
  if (is_lost()) {
    auto committed = come_back();
    if (!committed) return committed;
    if (*committed) return false;
  }
  counted_ = 0;
  auto done = database_->run("BEGIN");
  if (done)
    done = database_->run_counted(
        "UPDATE writer SET commits=?1 WHERE owner=?2", [this](std::uint64_t rows) { counted_ = rows; }, commits_ + 1,
        owner_);
  if (!done) return tl::unexpected(done.error());
  return true;
}

Result<void> PostgresWriterConnection::commit() {
  if (auto settled = database_->settle(); !settled) return settled;
  if (counted_ != 1)
    return failure(ErrorCode::bad_input, database_->name() +
                                             ": another headframe-server has taken the database over; "
                                             "stop that one before this one is started anew");
  in_doubt_ = true;
  auto done = database_->run("COMMIT");
  if (done) done = database_->settle();
  if (!done && is_lost()) return done;
  in_doubt_ = false;
  commits_ += done ? 1 : 0;
  return done;
}

void PostgresWriterConnection::rollback() {
  if (!is_lost()) (void)database_->execute("ROLLBACK");
}

}  // namespace headframe
