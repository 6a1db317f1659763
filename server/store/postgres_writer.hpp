#pragma once

#include "server/store/postgres.hpp"
#include "server/store/writer_connection.hpp"

namespace headframe {

/// Takes the database for one server while the connection lasts, with a session-level advisory lock. The connection of
/// a server that died may still hold the lock, because PostgreSQL ends it only when its current work is done; unless
/// `once`, this waits for that for at most half a minute. refused: another server holds the lock and is alive; the
/// message says which.
Result<void> take_for_one_server(PostgresDatabase& database, bool once = false);

/// The same without waiting; false: another connection holds the lock.
Result<bool> try_to_take(PostgresDatabase& database);
/// A message that the database is in use, and by whom, as far as the role may see it.
std::string in_use(PostgresDatabase& database);

/// A random number that identifies one run of a server.
std::int64_t random_mark();

/// The only connection that writes. The one row of table `writer` names the server that writes and counts its commits,
/// and every transaction updates it. So the outcome of a commit whose answer was lost can be determined, a server that
/// was cut off while another took over writes nothing, and a database that lost acknowledged commits is detected.
class PostgresWriterConnection final : public WriterConnection {
 public:
  /// `database` must be connected, taken, and have its tables. `mark` names this server in it; 0: a random one.
  static Result<std::unique_ptr<PostgresWriterConnection>> open(std::unique_ptr<PostgresDatabase> database,
                                                                std::int64_t mark = 0);

  Database& database() override { return *database_; }
  Result<bool> begin() override;
  Result<void> commit() override;
  void rollback() override;
  Result<void> look_after() override;
  bool is_lost() const override { return !has_it_ || !database_->is_connected(); }

 private:
  explicit PostgresWriterConnection(std::unique_ptr<PostgresDatabase> database) : database_(std::move(database)) {}
  Result<void> reconnect();
  Result<bool> come_back();
  Result<bool> found_committed();

  std::unique_ptr<PostgresDatabase> database_;
  std::int64_t owner_ = 0, commits_ = 0;  // commits known to be durable
  bool has_it_ = true;                    // the database, since the connection was made
  bool in_doubt_ = false;                 // a commit was sent and not answered
  std::uint64_t counted_ = 0;             // rows of `writer` that this transaction has updated
};

}  // namespace headframe
