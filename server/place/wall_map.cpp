#include "server/place/wall_map.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "common/descriptor/wall_profile.hpp"

namespace headframe {
namespace {

constexpr float wall_reach_m = 30;
constexpr float free_reach_m = 20;
constexpr int tile_cells = 32;

/// Counts how often rays ended in a cell and how often they passed through. Cells are stored in tiles, created when
/// first used.
class Canvas {
 public:
  explicit Canvas(float cell_m) : cell_m_(cell_m) {}

  void ray(const Eigen::Vector2f& origin, const Eigen::Vector2f& direction, float range_m) {
    const auto cells = std::lround(std::min(range_m - cell_m_, free_reach_m) / cell_m_);
    for (long i = 0; i < cells; ++i) ++at(origin + (static_cast<float>(i) + 0.5F) * cell_m_ * direction).free;
    if (range_m < wall_reach_m) ++at(origin + range_m * direction).wall;
  }

  /// Free cells beside a wall are left out, because half a cell of misalignment would put them on another map's walls.
  WallMap map() const {
    WallMap map;
    map.cell_m = cell_m_;
    for (const Tile& tile : tiles_)
      for (int y = 0; y < tile_cells; ++y)
        for (int x = 0; x < tile_cells; ++x) {
          const Cell& cell = tile.cells[offset(x, y)];
          const Eigen::Vector2i index = tile.first + Eigen::Vector2i(x, y);
          const Eigen::Vector2f centre = (index.cast<float>().array() + 0.5F) * cell_m_;
          if (is_wall(cell))
            map.walls.push_back(centre);
          else if (cell.free > 1 && !beside_wall(index))
            map.free.push_back(centre);
        }
    return map;
  }

 private:
  struct Cell {
    std::uint16_t wall = 0, free = 0;
  };
  struct Tile {
    Eigen::Vector2i first;
    std::array<Cell, std::size_t{tile_cells} * tile_cells> cells{};
  };

  static bool is_wall(const Cell& cell) { return cell.wall > 0 && 2 * cell.wall >= cell.free; }
  static std::size_t offset(int x, int y) {
    return static_cast<std::size_t>(y) * tile_cells + static_cast<std::size_t>(x);
  }
  static int tile_of(int cell) { return cell >= 0 ? cell / tile_cells : -((tile_cells - 1 - cell) / tile_cells); }
  static std::uint64_t key(int x, int y) {
    return std::uint64_t{static_cast<std::uint32_t>(x)} << 32 | static_cast<std::uint32_t>(y);
  }

  bool beside_wall(const Eigen::Vector2i& c) const {
    for (int y = c.y() - 1; y <= c.y() + 1; ++y)
      for (int x = c.x() - 1; x <= c.x() + 1; ++x) {
        const int tx = tile_of(x), ty = tile_of(y);
        const auto it = where_.find(key(tx, ty));
        if (it != where_.end() && is_wall(tiles_[it->second].cells[offset(x - tx * tile_cells, y - ty * tile_cells)]))
          return true;
      }
    return false;
  }

  Cell& at(const Eigen::Vector2f& p) {
    const int x = static_cast<int>(std::floor(p.x() / cell_m_)), y = static_cast<int>(std::floor(p.y() / cell_m_));
    const int tx = tile_of(x), ty = tile_of(y);
    if (tiles_.empty() || tx != last_x_ || ty != last_y_) {
      const auto [it, fresh] = where_.try_emplace(key(tx, ty), tiles_.size());
      if (fresh) tiles_.push_back({{tx * tile_cells, ty * tile_cells}, {}});
      last_ = it->second;
      last_x_ = tx;
      last_y_ = ty;
    }
    return tiles_[last_].cells[offset(x - tx * tile_cells, y - ty * tile_cells)];
  }

  float cell_m_;
  std::unordered_map<std::uint64_t, std::size_t> where_;
  std::vector<Tile> tiles_;  // in the order of first touch: deterministic
  std::size_t last_ = 0;     // the tile touched last, and where it is
  int last_x_ = 0, last_y_ = 0;
};

}  // namespace

WallMap draw_wall_map(std::span<const Keyframe> keyframes, float cell_m) {
  Canvas canvas(cell_m);
  for (const Keyframe& keyframe : keyframes) {
    const Eigen::Vector2f origin = keyframe.T_local_sensor.translation().head<2>().cast<float>();
    const double yaw = yaw_rad(keyframe.T_local_sensor);
    for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
      const float range = decode_wall_range_m(keyframe.walls.code[i]);
      if (range == 0) continue;
      const double azimuth = yaw + (static_cast<double>(i) + 0.5) * 2 * std::numbers::pi / WallProfile::sectors;
      canvas.ray(origin, Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth)).cast<float>(), range);
    }
  }
  return canvas.map();
}

}  // namespace headframe
