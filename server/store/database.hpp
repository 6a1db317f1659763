#pragma once
// A connection to an SQL database. The store's statements are written once, for SQLite and PostgreSQL.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "common/result.hpp"

namespace headframe {

struct Blob {
  std::string_view bytes;
};

/// The value of a question mark. Text and blobs are not copied: callers keep them valid until the call returns.
using SqlValue = std::variant<std::monostate, std::int64_t, double, std::string_view, Blob>;  // monostate: NULL

inline SqlValue sql_value(std::int64_t value) { return value; }
inline SqlValue sql_value(std::uint64_t value) { return static_cast<std::int64_t>(value); }
inline SqlValue sql_value(std::uint32_t value) { return std::int64_t{value}; }
inline SqlValue sql_value(int value) { return std::int64_t{value}; }
inline SqlValue sql_value(double value) { return value; }
inline SqlValue sql_value(std::string_view value) { return value; }
inline SqlValue sql_value(Blob value) { return value; }

/// The current row of a query; valid only during the visit.
class Row {
 public:
  virtual std::int64_t integer(int column) const = 0;
  virtual double real(int column) const = 0;  // NULL is read as NaN, because SQLite stores NaN as NULL
  virtual bool is_null(int column) const = 0;
  virtual std::string_view blob(int column) const = 0;
  std::string text(int column) const { return std::string(blob(column)); }

 protected:
  ~Row() = default;
};

/// One connection. Not thread safe. In a statement ? stands for the next value, ?N for the Nth. Errors: unavailable:
/// the disk is full, slow or locked, or the database does not answer (may be temporary); invalid_argument: only this
/// statement is wrong; bad_input: the database cannot be written, is damaged or not a database; internal otherwise.
/// Messages name the database.
class Database {
 public:
  using Visit = std::function<void(const Row&)>;
  using Changed = std::function<void(std::uint64_t rows)>;

  virtual ~Database() = default;

  /// Any statements, without values.
  virtual Result<void> execute(const std::string& sql) = 0;

  /// A statement without result rows. Its answer may be read later; then an error is returned by the next call that
  /// waits for answers, as all other functions do.
  template <class... Values>
  Result<void> run(std::string_view sql, const Values&... values) {
    return change(sql, std::array<SqlValue, sizeof...(Values)>{sql_value(values)...}, {});
  }

  /// The same; `changed` is called with the number of rows changed, by the end of settle() at the latest.
  template <class... Values>
  Result<void> run_counted(std::string_view sql, const Changed& changed, const Values&... values) {
    return change(sql, std::array<SqlValue, sizeof...(Values)>{sql_value(values)...}, changed);
  }

  template <class... Values>
  Result<void> each(std::string_view sql, const Visit& visit, const Values&... values) {
    return query(sql, std::array<SqlValue, sizeof...(Values)>{sql_value(values)...}, visit);
  }

  virtual Result<void> change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) = 0;
  virtual Result<void> query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) = 0;

  /// False: the connection was lost, and every call fails (unavailable) until it is restored.
  virtual bool is_connected() const { return true; }

  /// Whether every answer takes a network round trip, so that extra queries should be avoided.
  virtual bool answers_from_afar() const = 0;

  /// Waits for the answers to all statements that were run.
  virtual Result<void> settle() = 0;
};

}  // namespace headframe
