#pragma once
// Appends numbers to binary data.

#include <array>
#include <bit>
#include <cstring>
#include <string>

namespace headframe {

static_assert(std::endian::native == std::endian::little, "what is written so (LAS, PLY) is little-endian");

/// Appends the bytes of a number as they are in memory.
template <class T>
void append_bytes(std::string& out, T value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

}  // namespace headframe
