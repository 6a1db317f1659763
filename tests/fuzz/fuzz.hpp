#pragma once
// For the fuzz targets: each is given bytes and must end without a crash, and with what it promises about them.

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace headframe::fuzz {

inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A promise that does not hold is a finding.
inline void require(bool holds) {
  if (!holds) std::abort();
}

/// The first byte, 0 when there is none; the rest stays.
inline std::uint8_t take_byte(std::string_view& bytes) {
  if (bytes.empty()) return 0;
  const auto byte = static_cast<std::uint8_t>(bytes.front());
  bytes.remove_prefix(1);
  return byte;
}

/// Cuts the bytes into pieces that begin with their length (2 bytes): a mutation of one leaves the others what they
/// are.
inline std::vector<std::string_view> pieces(std::string_view bytes) {
  std::vector<std::string_view> all;
  while (!bytes.empty()) {
    const std::size_t high = take_byte(bytes), length = high << 8 | take_byte(bytes);
    all.push_back(bytes.substr(0, length));
    bytes.remove_prefix(all.back().size());
  }
  return all;
}

}  // namespace headframe::fuzz
