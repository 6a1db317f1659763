#include "server/surroundings/seen_rock.hpp"

#include <cmath>
#include <numbers>

#include "common/descriptor/wall_profile.hpp"

namespace headframe {
namespace {

constexpr double cell_m = 0.5, level_m = 2;  // cells are columns: a wall is in one from floor to roof

struct Cell {
  std::int64_t x = 0, y = 0, z = 0;
};

Cell cell_of(const Eigen::Vector3d& p_m) {
  const auto whole = [](double value) { return static_cast<std::int64_t>(std::floor(value)); };
  return {whole(p_m.x() / cell_m), whole(p_m.y() / cell_m), whole(p_m.z() / level_m)};
}

std::uint64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::uint64_t mask = (1ULL << 24) - 1;  // 8000 km of cells
  return (static_cast<std::uint64_t>(x) & mask) << 40 | (static_cast<std::uint64_t>(y) & mask) << 16 |
         (static_cast<std::uint64_t>(z) & 0xffff);
}

template <class Visit>
void each_wall(const Pose& T_component_sensor, const WallProfile& walls, Visit visit) {
  constexpr double sector_rad = 2 * std::numbers::pi / static_cast<double>(WallProfile::sectors);
  const double heading_rad = yaw_rad(T_component_sensor);
  for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
    const double range_m = decode_wall_range_m(walls.code[i]);
    if (walls.code[i] == 0 || range_m > SeenRock::reach_m) continue;
    const double azimuth_rad = heading_rad + (static_cast<double>(i) + 0.5) * sector_rad;
    visit(cell_of(T_component_sensor.translation() +
                  range_m * Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0)));
  }
}

}  // namespace

void SeenRock::add(const Pose& T_component_sensor, const WallProfile& walls) {
  each_wall(T_component_sensor, walls, [&](const Cell& c) { cells_.insert(key_of(c.x, c.y, c.z)); });
}

std::optional<double> SeenRock::share_seen(const Pose& T_component_sensor, const WallProfile& walls) const {
  int all = 0, seen = 0;
  const auto is_near = [&](const Cell& c) {
    for (std::int64_t z = c.z - 1; z <= c.z + 1; ++z)
      for (std::int64_t x = c.x - 1; x <= c.x + 1; ++x)
        for (std::int64_t y = c.y - 1; y <= c.y + 1; ++y)
          if (cells_.contains(key_of(x, y, z))) return true;
    return false;
  };
  each_wall(T_component_sensor, walls, [&](const Cell& c) {
    ++all;
    seen += is_near(c) ? 1 : 0;
  });
  if (all < least_walls) return std::nullopt;
  return static_cast<double>(seen) / all;
}

}  // namespace headframe
