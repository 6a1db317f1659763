#include "server/place/wall_map.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "common/descriptor/wall_profile.hpp"

namespace headframe {
namespace {

constexpr float wall_reach_m = 30;
constexpr float free_reach_m = 20;

/// How often rays ended in a cell, and how often they went through.
class Canvas {
 public:
  explicit Canvas(float cell_m) : cell_m_(cell_m) {}

  void ray(const Eigen::Vector2f& origin, const Eigen::Vector2f& direction, float range_m) {
    const auto cells = std::lround(std::min(range_m - cell_m_, free_reach_m) / cell_m_);
    for (long i = 0; i < cells; ++i) ++at(origin + (static_cast<float>(i) + 0.5F) * cell_m_ * direction).free;
    if (range_m < wall_reach_m) ++at(origin + range_m * direction).wall;
  }

  /// Free cells beside a wall are left out: turned onto another map by half a cell they would stand on its walls.
  WallMap map() const {
    WallMap map;
    map.cell_m = cell_m_;
    for (const Cell& cell : cells_) {
      const Eigen::Vector2f centre = (cell.index.cast<float>().array() + 0.5F) * cell_m_;
      if (is_wall(cell))
        map.walls.push_back(centre);
      else if (cell.free > 1 && !beside_wall(cell))
        map.free.push_back(centre);
    }
    return map;
  }

 private:
  struct Cell {
    Eigen::Vector2i index;
    int wall = 0, free = 0;
  };

  static bool is_wall(const Cell& cell) { return cell.wall > 0 && 2 * cell.wall >= cell.free; }

  bool beside_wall(const Cell& cell) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if (const auto it = where_.find(key(cell.index + Eigen::Vector2i(dx, dy)));
            it != where_.end() && is_wall(cells_[it->second]))
          return true;
    return false;
  }

  static std::uint64_t key(const Eigen::Vector2i& c) {
    return std::uint64_t{static_cast<std::uint32_t>(c.x())} << 32 | static_cast<std::uint32_t>(c.y());
  }

  Cell& at(const Eigen::Vector2f& p) {
    const Eigen::Vector2i c = (p / cell_m_).array().floor().cast<int>();
    const auto [it, fresh] = where_.try_emplace(key(c), cells_.size());
    if (fresh) cells_.push_back({c});
    return cells_[it->second];
  }

  float cell_m_;
  std::unordered_map<std::uint64_t, std::size_t> where_;
  std::vector<Cell> cells_;  // in the order of first touch: deterministic
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
