#pragma once
// A thin coat over libpq: statements are prepared once and kept, those without rows are sent one after the other and
// answered together (pipeline mode), errors are values.

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "server/store/database.hpp"

struct pg_conn;
struct pg_result;

namespace headframe {

/// What a PostgreSQL is called in messages: database and host, without user and password. bad_input: libpq does not
/// understand the URL.
Result<std::string> postgres_name(const std::string& url);

/// A connection to PostgreSQL 12 or newer. All tables are looked for in its schema `headframe`. unavailable also when
/// the server goes away, is shut down, or says nothing for 30 s: the connection is lost then, and every call fails so
/// until connect() succeeds. What fails in a transaction fails all of it.
class PostgresDatabase final : public Database {
 public:
  /// Does not connect. `name` as postgres_name gives it.
  PostgresDatabase(std::string url, std::string name);
  ~PostgresDatabase() override;

  /// A new connection in place of the one before. unavailable: no server answers there, or it is a standby; bad_input:
  /// it will not have us (no such database or role, another password), or is not fit to keep what is acknowledged.
  Result<void> connect();
  bool is_connected() const override { return connection_ != nullptr; }
  const std::string& name() const { return name_; }

  Result<void> execute(const std::string& sql) override;
  Result<void> change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) override;
  Result<void> query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) override;
  bool answers_from_afar() const override { return true; }
  Result<void> settle() override;

 private:
  struct Finish {
    void operator()(pg_conn* connection) const;
  };
  struct Clear {
    void operator()(pg_result* result) const;
  };
  using PgResult = std::unique_ptr<pg_result, Clear>;
  struct Sent {
    std::string prepares;  // the statement that it makes known to the server; empty: it runs one
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
  std::unique_ptr<pg_conn, Finish> connection_;            // null: lost
  std::unordered_map<std::string, std::string> prepared_;  // statement, and its name
  std::deque<Sent> sent_;                                  // in pipeline mode, and not answered
  std::size_t sent_bytes_ = 0;
  std::uint64_t names_ = 0;
  std::optional<Error> first_fault_;  // of what was sent
};

}  // namespace headframe
