#include "common/descriptor/scan_context.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace headframe {
namespace {

constexpr std::size_t rings = 20;
constexpr std::size_t sectors = 60;
constexpr float reach_m = 40.0F;

struct Cell {
  float low = 0;
  float high = 0;
  bool seen = false;
  float height() const { return seen ? high - low : 0; }
};
using Grid = std::array<std::array<Cell, sectors>, rings>;

Grid draw(const Points& points) {
  Grid grid;
  for (const auto& p : points) {
    const float r = std::hypot(p.x(), p.y());
    if (r >= reach_m) continue;
    const auto ring = static_cast<std::size_t>(std::sqrt(r / reach_m) * rings);
    const float turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi_v<float>);
    const auto sector = static_cast<std::size_t>((turn < 0 ? turn + 1 : turn) * sectors) % sectors;
    Cell& cell = grid[std::min(ring, rings - 1)][sector];
    cell.low = cell.seen ? std::min(cell.low, p.z()) : p.z();
    cell.high = cell.seen ? std::max(cell.high, p.z()) : p.z();
    cell.seen = true;
  }
  return grid;
}

}  // namespace

Result<Descriptor> ScanContext::extract(const Points& points_level) const {
  if (auto enough = enough_points(points_level); !enough) return tl::unexpected(enough.error());
  const Grid grid = draw(points_level);
  Descriptor d;
  d.w.assign(sectors, 0);
  for (const auto& ring : grid) {
    float seen = 0, sum = 0, squares = 0;
    for (std::size_t s = 0; s < sectors; ++s) {
      const float h = ring[s].height();
      seen += ring[s].seen ? 1.0F : 0.0F;
      sum += h;
      squares += h * h;
      d.w[s] += h / rings;
    }
    const float mean = sum / sectors;
    d.q.push_back(mean);
    d.q.push_back(std::sqrt(std::max(0.0F, squares / sectors - mean * mean)));
    d.q.push_back(seen / sectors);
  }
  return d;
}

}  // namespace headframe
