#include "server/place/wall_cells.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "server/support/wide.hpp"

namespace headframe {
namespace {

typedef std::int16_t Shorts __attribute__((vector_size(16)));
static_assert(std::endian::native == std::endian::little);  // the lower half of a short is the cell on the left
static_assert(cells_at_once * 128 <= 32768);                // the sums of a block fit into a short

/// Without branches, so that it is vectorised.
HEADFRAME_WIDE void find_cells(const float* xy, std::size_t count, const OnGrid& grid, int margin, std::int32_t outside,
                               std::int32_t* cell) {
  const float a = grid.R(0, 0), b = grid.R(0, 1), c = grid.R(1, 0), d = grid.R(1, 1), u = grid.t.x(), v = grid.t.y();
  const auto low = static_cast<float>(margin), right = grid.size.x() - low, top = grid.size.y() - low;
  const int columns = grid.columns;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = a * xy[2 * i] + b * xy[2 * i + 1] + u, y = c * xy[2 * i] + d * xy[2 * i + 1] + v;
    const bool inside = (x >= low) & (y >= low) & (x < right) & (y < top);
    const float at_x = inside ? x : 0, at_y = inside ? y : 0;
    const int here = static_cast<int>(at_y) * columns + static_cast<int>(at_x);
    cell[i] = inside ? here : outside;
  }
}

/// Sixteen cells of a row are eight shorts of two: the cells at even places are their lower halves, those at odd places
/// their upper halves. The sums stay in registers, two for each row of the window, or one where stride is 2.
template <int reach, int stride>
void add_all(const CellIndices& cells, std::size_t count, const CellWorth& worth, std::ptrdiff_t columns,
             std::int32_t* scores) {
  constexpr int side = 2 * reach / stride + 1;
  Shorts even[side] = {}, odd[side] = {};
  for (std::size_t i = 0; i < count; ++i) {
    const std::int8_t* corner = worth.data() + cells[i] - reach * columns - reach;
    for (int row = 0; row < side; ++row) {
      Shorts pairs;
      std::memcpy(&pairs, corner + row * stride * columns, sizeof pairs);
      even[row] += pairs << 8 >> 8;
      if constexpr (stride == 1) odd[row] += pairs >> 8;
    }
  }
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column, ++scores) {
      const int at = column * stride;
      *scores += at % 2 == 0 ? even[row][at / 2] : odd[row][at / 2];
    }
}

}  // namespace

std::size_t cells_under(std::span<const Eigen::Vector2f> points, const OnGrid& grid, int margin, std::int32_t outside,
                        CellIndices& cells) {
  const std::size_t count = std::min(points.size(), cells_at_once);
  if (count > 0) find_cells(points.front().data(), count, grid, margin, outside, cells.data());
  return count;
}

void add_windows(std::span<const Eigen::Vector2f> points, std::size_t every, const OnGrid& grid, const CellWorth& worth,
                 CellWindow window, std::span<std::int32_t> scores) {
  const std::int32_t empty = window.reach * grid.columns + window.reach;
  std::array<Eigen::Vector2f, cells_at_once> some;
  CellIndices cells;
  for (std::size_t i = 0; i < points.size();) {
    std::size_t count = 0;
    for (; i < points.size() && count < some.size(); i += every) some[count++] = points[i];
    cells_under({some.data(), count}, grid, window.reach, empty, cells);
    if (window.reach == 6)
      add_all<6, 2>(cells, count, worth, grid.columns, scores.data());
    else if (window.reach == 2)
      add_all<2, 1>(cells, count, worth, grid.columns, scores.data());
    else
      for (std::size_t k = 0; k < count; ++k) scores[0] += worth[static_cast<std::size_t>(cells[k])];
  }
}

}  // namespace headframe
