#pragma once
// Looks up many cells of a wall map's grid at once. The loops are vectorised; results are the same on every processor.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace headframe {

/// What a cell of one map is worth that falls on each cell of the other's grid, row by row. Padded, because windows are
/// read in whole registers.
using CellWorth = std::vector<std::int8_t>;
inline constexpr std::size_t worth_padding = 16;

/// Where points of one map fall on the grid of another: a point p on column and row R p + t, if these are below `size`.
struct OnGrid {
  Eigen::Matrix2f R;
  Eigen::Vector2f t, size;
  int columns = 0;  // stored for each row, at least size.x()
};

/// The cells around a point that are looked up: from -reach to reach on both axes, `stride` apart.
struct CellWindow {
  int reach = 0, stride = 1;
  std::size_t side() const { return 2 * static_cast<std::size_t>(reach) / static_cast<std::size_t>(stride) + 1; }
};

inline constexpr std::size_t cells_at_once = 256;
using CellIndices = std::array<std::int32_t, cells_at_once>;

/// The cells on which the first points fall, at most cells_at_once. A point nearer to the grid's edge than margin, or
/// beyond it, gets `outside`. Returns how many points were taken.
std::size_t cells_under(std::span<const Eigen::Vector2f> points, const OnGrid& grid, int margin, std::int32_t outside,
                        CellIndices& cells);

/// Adds the worth of the cells around each point to `scores`, row by row, for all shifts of a window at once; takes
/// each `every`th point. Windows: reach 6 and stride 2, reach 2 and stride 1, or a single cell. As far as `reach`
/// from the cell (reach, reach), the grid has to be empty.
void add_windows(std::span<const Eigen::Vector2f> points, std::size_t every, const OnGrid& grid, const CellWorth& worth,
                 CellWindow window, std::span<std::int32_t> scores);

}  // namespace headframe
