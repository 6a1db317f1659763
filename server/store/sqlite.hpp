#pragma once
// A thin coat over SQLite: statements are prepared once and kept, errors are values.

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

#include "common/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace headframe {

struct Blob {
  std::string_view bytes;
};

/// The current row of a query; only good inside its visit.
class Row {
 public:
  explicit Row(sqlite3_stmt* statement) : statement_(statement) {}
  std::int64_t integer(int column) const;
  double real(int column) const;  // NULL is NaN: SQLite has no other word for it
  bool is_null(int column) const;
  std::string text(int column) const { return std::string(blob(column)); }
  std::string_view blob(int column) const;

 private:
  sqlite3_stmt* statement_;
};

/// One connection. Not thread safe. Errors: unavailable when the disk is full, slow or locked (may pass);
/// invalid_argument when this statement alone is at fault; bad_input when the file can not be written, is damaged or no
/// database; internal otherwise. Messages name the file.
class Database {
 public:
  static Result<Database> open(const std::string& path);

  /// Whether its file, or its log, still lies where it was opened; else nobody will find again what is written there.
  /// bad_input: it does not.
  Result<void> still_there() const;

  /// Any statements, no values.
  Result<void> execute(const std::string& sql);

  template <class... Values>
  Result<void> run(std::string_view sql, const Values&... values) {
    return each(
        sql, [](const Row&) {}, values...);
  }

  template <class Visit, class... Values>
  Result<void> each(std::string_view sql, Visit visit, const Values&... values) {
    auto statement = prepare(sql);
    if (!statement) return tl::unexpected(statement.error());
    int index = 0;
    (bind(*statement, ++index, values), ...);
    return step(*statement, visit);
  }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };

  Database(std::string path, sqlite3* handle) : path_(std::move(path)), handle_(handle) {}
  Result<sqlite3_stmt*> prepare(std::string_view sql);
  Result<void> step(sqlite3_stmt* statement, const std::function<void(const Row&)>& visit);
  tl::unexpected<Error> fault(int code) const;

  // A temporary string would be gone when the statement runs: callers keep what they bind until the call returns.
  static void bind(sqlite3_stmt* statement, int index, std::int64_t value);
  static void bind(sqlite3_stmt* statement, int index, std::uint64_t value) {
    bind(statement, index, static_cast<std::int64_t>(value));
  }
  static void bind(sqlite3_stmt* statement, int index, std::uint32_t value) {
    bind(statement, index, std::int64_t{value});
  }
  static void bind(sqlite3_stmt* statement, int index, int value) { bind(statement, index, std::int64_t{value}); }
  static void bind(sqlite3_stmt* statement, int index, double value);
  static void bind(sqlite3_stmt* statement, int index, std::string_view value);
  static void bind(sqlite3_stmt* statement, int index, Blob value);

  std::string path_;
  std::unique_ptr<sqlite3, Close> handle_;
  std::unordered_map<std::string, std::unique_ptr<sqlite3_stmt, Finalize>> statements_;  // gone before handle_
};

}  // namespace headframe
