#include "server/store/row_checksum.hpp"

#include <bit>

namespace headframe {

RowChecksum& RowChecksum::add(std::uint64_t value) {
  for (int byte = 0; byte < 8; ++byte, value >>= 8) sum_ = (sum_ ^ (value & 0xff)) * 1099511628211ULL;
  return *this;
}

RowChecksum& RowChecksum::add(double value) { return add(std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value)); }

/// Includes the length, so that bytes moved from the end of one column to the start of the next change the sum.
RowChecksum& RowChecksum::add(std::string_view bytes) {
  for (const char c : bytes) sum_ = (sum_ ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return add(std::uint64_t{bytes.size()});
}

std::int64_t RowChecksum::value() const { return std::bit_cast<std::int64_t>(sum_); }

}  // namespace headframe
