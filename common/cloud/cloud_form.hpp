#pragma once
// Shared by the encoder and the decoder of clouds.

#include <array>
#include <cstdint>
#include <string>

#include "common/result.hpp"

namespace headframe::cloud_form {

enum Form : std::uint64_t { differences = 1, octree = 2, with_intensity = 3 };
inline constexpr std::size_t octree_points = 262'144;     // limit for form 2: decoding takes some 0.2 us per point
inline constexpr std::size_t intensity_points = 262'144;  // the same for intensities
inline constexpr std::size_t octree_points_a_byte = 2;    // limit
inline constexpr double farthest_cell = 1e12;             // keeps products of cells and metres exact in a double

using Cell = std::array<std::int64_t, 3>;

/// Whether decoding an octree of this many points is fast enough relative to its bytes.
inline bool is_quick(std::size_t points, std::size_t stream_bytes) {
  return points <= octree_points && points / octree_points_a_byte <= stream_bytes;
}

inline tl::unexpected<Error> damaged(const std::string& what) {
  return failure(ErrorCode::bad_input, "encoded cloud: " + what);
}

}  // namespace headframe::cloud_form
