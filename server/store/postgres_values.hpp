#pragma once
// Transfers values to and from PostgreSQL in its binary format, which preserves them bit for bit.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "server/store/database.hpp"

struct pg_result;

namespace headframe {

/// The values of one statement in the form that libpq expects. Refers to the text and blobs from which it was made.
struct PostgresValues {
  explicit PostgresValues(std::span<const SqlValue> values);
  PostgresValues(const PostgresValues&) = delete;
  PostgresValues& operator=(const PostgresValues&) = delete;

  int count() const { return static_cast<int>(data.size()); }

  std::vector<const char*> data;  // null: NULL
  std::vector<int> lengths, formats;
  std::vector<unsigned> types;  // OIDs of PostgreSQL's types; 0: inferred from the statement
  std::size_t bytes = 0;

 private:
  void add(std::string_view value, unsigned type);
  std::vector<std::array<char, 8>> numbers_;
};

/// A row of a result in binary format.
class PostgresRow final : public Row {
 public:
  PostgresRow(const pg_result* result, int row) : result_(result), row_(row) {}
  std::int64_t integer(int column) const override;
  double real(int column) const override;
  bool is_null(int column) const override;
  std::string_view blob(int column) const override;

 private:
  const pg_result* result_;
  int row_;
};

/// The statement with each ? or ?N outside of quotes replaced by $N.
std::string with_numbered_values(std::string_view sql);

}  // namespace headframe
