#include "server/store/postgres_values.hpp"

#include <libpq-fe.h>

#include <bit>
#include <cctype>
#include <limits>

namespace headframe {
namespace {

// Of the catalogue pg_type; they never change.
constexpr unsigned bytea_type = 17, int8_type = 20, text_type = 25, float8_type = 701;

std::array<char, 8> big_endian(std::uint64_t value) {
  std::array<char, 8> bytes;
  for (std::size_t i = 8; i-- > 0; value >>= 8) bytes.at(i) = static_cast<char>(value & 0xff);
  return bytes;
}

std::uint64_t from_big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = (value << 8) | static_cast<unsigned char>(c);
  return value;
}

}  // namespace

PostgresValues::PostgresValues(std::span<const SqlValue> values) {
  numbers_.reserve(values.size());  // pointers into it stay
  for (const SqlValue& value : values) {
    if (const auto* whole = std::get_if<std::int64_t>(&value))
      add({numbers_.emplace_back(big_endian(static_cast<std::uint64_t>(*whole))).data(), 8}, int8_type);
    else if (const auto* real = std::get_if<double>(&value))
      add({numbers_.emplace_back(big_endian(std::bit_cast<std::uint64_t>(*real))).data(), 8}, float8_type);
    else if (const auto* text = std::get_if<std::string_view>(&value))
      add(*text, text_type);
    else if (const auto* blob = std::get_if<Blob>(&value))
      add(blob->bytes, bytea_type);
    else
      data.push_back(nullptr), lengths.push_back(0), formats.push_back(1), types.push_back(0);
  }
}

void PostgresValues::add(std::string_view value, unsigned type) {
  data.push_back(value.data() != nullptr ? value.data() : "");
  lengths.push_back(static_cast<int>(value.size()));
  formats.push_back(1);
  types.push_back(type);
  bytes += value.size();
}

std::int64_t PostgresRow::integer(int column) const {
  const std::string_view bytes = blob(column);
  const std::uint64_t value = from_big_endian(bytes);
  if (bytes.size() == 4) return static_cast<std::int32_t>(static_cast<std::uint32_t>(value));
  return static_cast<std::int64_t>(value);  // bigint, or a truth value
}

double PostgresRow::real(int column) const {
  if (is_null(column)) return std::numeric_limits<double>::quiet_NaN();
  return std::bit_cast<double>(from_big_endian(blob(column)));
}

bool PostgresRow::is_null(int column) const { return PQgetisnull(result_, row_, column) != 0; }

std::string_view PostgresRow::blob(int column) const {
  return {PQgetvalue(result_, row_, column), static_cast<std::size_t>(PQgetlength(result_, row_, column))};
}

std::string with_numbered_values(std::string_view sql) {
  std::string out;
  bool quoted = false;
  int next = 0;
  for (std::size_t i = 0; i < sql.size(); ++i) {
    quoted ^= sql[i] == '\'';
    if (sql[i] != '?' || quoted) {
      out += sql[i];
      continue;
    }
    out += '$';
    if (i + 1 == sql.size() || std::isdigit(static_cast<unsigned char>(sql[i + 1])) == 0) out += std::to_string(++next);
  }
  return out;
}

}  // namespace headframe
