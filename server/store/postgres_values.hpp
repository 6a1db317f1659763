#pragma once
// How values go to PostgreSQL and come back: in its binary format, so that they are bit for bit what they were.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "server/store/database.hpp"

struct pg_result;

namespace headframe {

/// The values of one statement as libpq takes them. Points to the text and blobs that it was made from.
struct PostgresValues {
  explicit PostgresValues(std::span<const SqlValue> values);
  PostgresValues(const PostgresValues&) = delete;
  PostgresValues& operator=(const PostgresValues&) = delete;

  int count() const { return static_cast<int>(data.size()); }

  std::vector<const char*> data;  // null: NULL
  std::vector<int> lengths, formats;
  std::vector<unsigned> types;  // of PostgreSQL's catalogue; 0: as the statement has it
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

/// The statement with $N where ? or ?N stands outside of quotes.
std::string with_numbered_values(std::string_view sql);

}  // namespace headframe
