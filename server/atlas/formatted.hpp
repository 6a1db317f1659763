#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

namespace headframe {

/// Formats like printf; at most 399 characters.
template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 400> out;
  const int size = std::snprintf(out.data(), out.size(), format, values...);
  return {out.data(), std::min(static_cast<std::size_t>(std::max(size, 0)), out.size() - 1)};
}

}  // namespace headframe
