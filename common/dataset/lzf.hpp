#pragma once
// LZF, the compression inside PCD's binary_compressed.

#include <optional>
#include <string>
#include <string_view>

namespace headframe::dataset {

/// Limit of how much LZF data can grow when unpacked (3 bytes give at most 264): check sizes against it first.
inline constexpr std::size_t lzf_most_growth = 88;

/// Unpacks into exactly size bytes; nullopt if the data is damaged or gives another number of bytes.
std::optional<std::string> lzf_unpack(std::string_view packed, std::size_t size);

}  // namespace headframe::dataset
