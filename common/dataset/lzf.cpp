#include "common/dataset/lzf.hpp"

#include <cstdint>

namespace headframe::dataset {

// A control byte below 32 is followed by that many bytes plus one, to be copied as they are. Any other one means:
// repeat earlier output. Its upper 3 bits are the length minus 2 (7: a further byte is added to it), its lower 5 bits
// and the last byte are the distance minus 1.
std::optional<std::string> lzf_unpack(std::string_view packed, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto left = [&] { return packed.size() - at; };
  const auto byte = [&] { return static_cast<std::size_t>(static_cast<std::uint8_t>(packed[at++])); };
  while (left() > 0) {
    const std::size_t control = byte();
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > left() || length > size - out.size()) return std::nullopt;
      out.append(packed.substr(at, length));
      at += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (left() < (length == 7 ? 2U : 1U)) return std::nullopt;
    if (length == 7) length += byte();
    length += 2;
    const std::size_t distance = ((control & 0x1f) << 8 | byte()) + 1;
    if (distance > out.size() || length > size - out.size()) return std::nullopt;
    // Byte by byte, because the copy may overlap what it writes; that is how LZF repeats a pattern.
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

}  // namespace headframe::dataset
