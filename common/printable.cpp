#include "common/printable.hpp"

#include <cstdint>

namespace headframe {
namespace {

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  // 0: no UTF-8
};

/// The first of a text that is not empty. Overlong forms, surrogates and what lies beyond Unicode are no UTF-8.
Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 && lead < 0xF8 ? 4 : lead >= 0xE0 && lead < 0xF0 ? 3 : lead >= 0xC0 ? 2 : 0;
  if (bytes == 0 || lead >= 0xF8 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return {};
    code = code << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < least[bytes] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return {};
  return {code, bytes};
}

bool within(std::uint32_t code, std::uint32_t first, std::uint32_t last) { return code >= first && code <= last; }

bool stands_for_itself(std::uint32_t code) {
  const bool control = code < 0x20 || within(code, 0x7F, 0x9F);
  const bool turns_direction =
      code == 0x061C || within(code, 0x200E, 0x200F) || within(code, 0x202A, 0x202E) || within(code, 0x2066, 0x2069);
  const bool invisible = code == 0x00AD || within(code, 0x200B, 0x200D) || within(code, 0x2060, 0x2065) ||
                         within(code, 0x206A, 0x206F) || code == 0xFEFF || within(code, 0xFFF9, 0xFFFB) ||
                         within(code, 0xE0000, 0xE007F);
  return !control && !turns_direction && !invisible && !within(code, 0x2028, 0x2029);
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Character c = first_of(text);
    if (c.bytes > 0 && stands_for_itself(c.code))
      out += text.substr(0, c.bytes);
    else
      out += '?';
    text.remove_prefix(c.bytes > 0 ? c.bytes : 1);
  }
  return out;
}

}  // namespace headframe
