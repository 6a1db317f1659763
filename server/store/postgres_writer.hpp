#pragma once

#include "server/store/postgres.hpp"
#include "server/store/writer_connection.hpp"

namespace headframe {

/// Takes the database for one server, as long as the connection lives: a session-level advisory lock. One that is still
/// held by the connection of a server that died is waited for, half a minute at most, unless `once`: PostgreSQL ends
/// such a connection when what it works on is done. refused: another server has it, and lives; the message says who.
Result<void> take_for_one_server(PostgresDatabase& database, bool once = false);

/// The same at once: false where another connection has it.
Result<bool> try_to_take(PostgresDatabase& database);
/// That the database is in use, and by whom, as far as the role may see it.
std::string in_use(PostgresDatabase& database);

/// What tells one run of a server from all others.
std::int64_t random_mark();

/// The one connection that writes. The row of table `writer` names the server that writes and counts its commits, and
/// each transaction changes it: so a commit whose answer was lost is found out, a server that was cut off while another
/// took over writes nothing, and a database that lost commits which were answered is noticed.
class PostgresWriterConnection final : public WriterConnection {
 public:
  /// On a connected database that was taken and has its tables. `mark` names this server in it; 0: a random one.
  static Result<std::unique_ptr<PostgresWriterConnection>> open(std::unique_ptr<PostgresDatabase> database,
                                                                std::int64_t mark = 0);

  Database& database() override { return *database_; }
  Result<bool> begin() override;
  Result<void> commit() override;
  void rollback() override;
  Result<void> look_after() override;
  bool is_lost() const override { return !database_->is_connected(); }

 private:
  explicit PostgresWriterConnection(std::unique_ptr<PostgresDatabase> database) : database_(std::move(database)) {}
  Result<void> reconnect();
  Result<bool> come_back();
  Result<bool> found_committed();

  std::unique_ptr<PostgresDatabase> database_;
  std::int64_t owner_ = 0, commits_ = 0;  // commits that were answered, or found
  bool in_doubt_ = false;                 // a commit was sent, and no answer came
  std::uint64_t counted_ = 0;             // rows of `writer` that this transaction has changed
};

}  // namespace headframe
