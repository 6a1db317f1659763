#pragma once
// A thin wrapper of libpq: statements are prepared once and kept, those without result rows are sent in sequence and
// answered together (pipeline mode), errors are values.

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "server/store/database.hpp"

struct pg_conn;
struct pg_result;

namespace headframe {

/// The name of a PostgreSQL database in messages: database and host, without user and password. bad_input: libpq cannot
/// parse the URL.
Result<std::string> postgres_name(const std::string& url);

/// A connection to PostgreSQL 12 or newer. All tables are in its schema `headframe`. unavailable also means that the
/// server went away, was shut down, or did not answer for 30 s: then the connection is lost, and every call fails until
/// connect() succeeds. A failure within a transaction makes all of it fail.
class PostgresDatabase final : public Database {
 public:
  /// Does not connect yet. `name` as returned by postgres_name.
  PostgresDatabase(std::string url, std::string name);
  ~PostgresDatabase() override;

  /// Makes a new connection, replacing an earlier one. unavailable: no server answers, or it is a standby; bad_input:
  /// it refuses the connection (no such database or role, wrong password), or is not configured to keep acknowledged
  /// data safely.
  Result<void> connect();
  bool is_connected() const override { return connection_ != nullptr; }
  const std::string& name() const { return name_; }

  Result<void> execute(const std::string& sql) override;
  Result<void> change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) override;
  Result<void> query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) override;
  bool answers_from_afar() const override { return true; }
  Result<void> settle() override;

  /// Waits until PostgreSQL notifies this connection of something that it LISTENs to, at most this long. True: it did,
  /// since this was last called.
  Result<bool> wait_for_notice(std::chrono::milliseconds most);

 private:
  struct Finish {
    void operator()(pg_conn* connection) const;
  };
  struct Clear {
    void operator()(pg_result* result) const;
  };
  using PgResult = std::unique_ptr<pg_result, Clear>;
  struct Sent {
    std::string prepares;  // name of the statement that it prepares; empty: it runs one
    Changed changed;
  };

  Result<void> reach();
  Result<void> make_fit();
  Result<std::string> known_as(std::string_view sql, const struct PostgresValues& values);
  Result<void> finish(const Visit& visit);
  void take_answer(Sent& of, const pg_result* result);
  Result<void> wait(bool to_write);
  Result<void> push_out();
  Result<PgResult> next_result();
  tl::unexpected<Error> fault(const pg_result* result);
  tl::unexpected<Error> lost(const std::string& why);

  const std::string url_, name_;
  std::unique_ptr<pg_conn, Finish> connection_;            // null: connection lost
  std::unordered_map<std::string, std::string> prepared_;  // names by statement
  std::deque<Sent> sent_;                                  // sent in pipeline mode and not yet answered
  std::size_t sent_bytes_ = 0;
  std::uint64_t names_ = 0;
  std::optional<Error> first_fault_;  // of the statements sent
};

}  // namespace headframe
