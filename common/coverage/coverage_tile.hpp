#pragma once
// Part of a grid that says, seen from above, what of a mine was seen, by whom and when: 32 x 32 cells of 1 m.

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

inline constexpr double coverage_cell_m = 1;
inline constexpr int coverage_tile_cells = 32;  // along each side of a tile
inline constexpr double coverage_time_s = 600;  // times are told in steps of this
inline constexpr double coverage_range_m = 30;  // what was seen farther from the sensor is left out

/// What was seen of a cell; any of them may hold, also a wall and free space, for a cell is wider than a wall is.
enum CoverageKind : std::uint8_t { coverage_free = 1, coverage_wall = 2, coverage_path = 4 };

struct CoverageCell {
  std::uint8_t what = 0;       // of CoverageKind; 0: nobody has seen it
  std::int32_t last_seen = 0;  // floor(stamp / coverage_time_s), by the clock of the robot that saw it last
  std::uint32_t session = 0;   // its number; of several in the same step of time the least
  bool operator==(const CoverageCell&) const = default;
};

/// Of a tile: the cells from index * coverage_tile_cells on along the axes of the component's frame.
struct TileIndex {
  std::int32_t x = 0, y = 0;
  auto operator<=>(const TileIndex&) const = default;
};

struct CoverageTile {
  std::array<CoverageCell, coverage_tile_cells * coverage_tile_cells> cells{};  // row by row: y * 32 + x
  std::map<std::uint32_t, std::int32_t> seen_by;  // all sessions that have seen any of it, and when last
};

/// As a tile travels: see "Coverage" in proto/headframe/v1/README.md. Deterministic, thread safe.
std::string encode_tile(const CoverageTile& tile);

/// Bytes may be anything; what it allocates is bounded. bad_input when they are no tile. Thread safe.
Result<CoverageTile> decode_tile(std::string_view bytes);

/// The step of time of a stamp; stamps beyond what the code holds count as the first or the last.
std::int32_t coverage_time(double stamp_s);

}  // namespace headframe
