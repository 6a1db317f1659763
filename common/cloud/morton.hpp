#pragma once
// Morton codes: the bits of three numbers interleaved, so that cells near each other mostly have similar codes.

#include <array>
#include <cstddef>
#include <cstdint>

namespace headframe::morton {

inline constexpr int axis_bits = 21;

namespace detail {

constexpr std::uint64_t spread(std::uint64_t v) {  // inserts two zero bits after each of 21 bits
  v = (v | v << 32) & 0x001f00000000ffffULL;
  v = (v | v << 16) & 0x001f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

constexpr std::uint64_t gather(std::uint64_t v) {
  v &= 0x1249249249249249ULL;
  v = (v | v >> 2) & 0x10c30c30c30c30c3ULL;
  v = (v | v >> 4) & 0x100f00f00f00f00fULL;
  v = (v | v >> 8) & 0x001f0000ff0000ffULL;
  v = (v | v >> 16) & 0x001f00000000ffffULL;
  return (v | v >> 32) & 0x1fffffULL;
}

}  // namespace detail

/// Each number has to be below 2^axis_bits.
constexpr std::uint64_t code(const std::array<std::uint64_t, 3>& cell) {
  return detail::spread(cell[0]) | detail::spread(cell[1]) << 1 | detail::spread(cell[2]) << 2;
}

constexpr std::array<std::uint64_t, 3> cell(std::uint64_t code) {
  return {detail::gather(code), detail::gather(code >> 1), detail::gather(code >> 2)};
}

}  // namespace headframe::morton
