#pragma once
// A tile of a map seen from above, of 32 x 32 cells of 1 m, which says what was seen of the mine, by whom and when.

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
inline constexpr double coverage_time_s = 600;  // resolution of times
inline constexpr double coverage_range_m = 30;  // things seen farther from the sensor are left out

/// What was seen of a cell, as flags. A cell can be both wall and free space, because it is wider than a wall.
enum CoverageKind : std::uint8_t { coverage_free = 1, coverage_wall = 2, coverage_path = 4 };

struct CoverageCell {
  std::uint8_t what = 0;       // flags of CoverageKind; 0: not seen by anybody
  std::int32_t last_seen = 0;  // floor(stamp / coverage_time_s), by the clock of the robot that saw it last
  std::uint32_t session = 0;   // its number; if several saw it in the same time step, the least
  bool operator==(const CoverageCell&) const = default;
};

/// The position of a tile: it has the cells from index * coverage_tile_cells on along the axes of the component's
/// frame.
struct TileIndex {
  std::int32_t x = 0, y = 0;
  auto operator<=>(const TileIndex&) const = default;
};

struct CoverageTile {
  std::array<CoverageCell, coverage_tile_cells * coverage_tile_cells> cells{};  // row by row: y * 32 + x
  std::map<std::uint32_t, std::int32_t> seen_by;  // all sessions that saw any of it, with the time of the last
};

/// The wire format: see "Coverage" in proto/headframe/v1/README.md. Deterministic, thread safe.
std::string encode_tile(const CoverageTile& tile);

/// Accepts any bytes; memory is bounded. bad_input: not a tile. Thread safe.
Result<CoverageTile> decode_tile(std::string_view bytes);

/// The time step of a stamp, clamped to what the code can represent.
std::int32_t coverage_time(double stamp_s);

}  // namespace headframe
