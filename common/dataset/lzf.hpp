#pragma once
// LZF, the compression inside PCD's binary_compressed.

#include <optional>
#include <string>
#include <string_view>

namespace headframe::dataset {

/// No LZF data grows by more than this when unpacked (3 bytes give at most 264): check sizes against it before
/// unpacking.
inline constexpr std::size_t lzf_most_growth = 88;

/// Unpacks into exactly size bytes; nothing when the data is damaged or gives more or fewer.
std::optional<std::string> lzf_unpack(std::string_view packed, std::size_t size);

}  // namespace headframe::dataset
