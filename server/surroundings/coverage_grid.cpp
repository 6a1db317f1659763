#include "server/surroundings/coverage_grid.hpp"

#include <cmath>
#include <numbers>

#include "common/descriptor/wall_profile.hpp"

namespace headframe {
namespace {

constexpr double step_m = coverage_cell_m / 2;  // along a ray; hits every cell that it crosses by more than half

std::int32_t floor_divided(std::int32_t a, std::int32_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

}  // namespace

void CoverageGrid::see(std::uint32_t session, const Pose& T_component_sensor, double stamp_s,
                       const WallProfile& walls) {
  constexpr double sector_rad = 2 * std::numbers::pi / static_cast<double>(WallProfile::sectors);
  const std::int32_t time = coverage_time(stamp_s);
  const Eigen::Vector2d from_m = T_component_sensor.translation().head<2>();
  const double heading_rad = yaw_rad(T_component_sensor);
  for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
    if (walls.code[i] == 0) continue;
    const double range_m = decode_wall_range_m(walls.code[i]);
    const double azimuth_rad = heading_rad + (static_cast<double>(i) + 0.5) * sector_rad;
    const Eigen::Vector2d ahead(std::cos(azimuth_rad), std::sin(azimuth_rad));
    const double free_m = std::min(range_m - step_m, coverage_range_m);
    for (int k = 0; k * step_m < free_m; ++k) mark(from_m + k * step_m * ahead, coverage_free, session, time);
    if (range_m <= coverage_range_m) mark(from_m + range_m * ahead, coverage_wall, session, time);
  }
}

void CoverageGrid::walk(std::uint32_t session, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m,
                        double stamp_s) {
  const Eigen::Vector2d from = from_m.head<2>(), way = to_m.head<2>() - from;
  const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / step_m)));
  for (int i = 0; i <= steps; ++i)
    mark(from + way * (static_cast<double>(i) / steps), coverage_path, session, coverage_time(stamp_s));
}

void CoverageGrid::mark(const Eigen::Vector2d& p_m, std::uint8_t what, std::uint32_t session, std::int32_t time) {
  constexpr double farthest_m = 1e9;
  if (!(p_m.cwiseAbs().maxCoeff() < farthest_m)) return;
  const auto x = static_cast<std::int32_t>(std::floor(p_m.x() / coverage_cell_m));
  const auto y = static_cast<std::int32_t>(std::floor(p_m.y() / coverage_cell_m));
  const TileIndex index{floor_divided(x, coverage_tile_cells), floor_divided(y, coverage_tile_cells)};
  auto tile = tiles_.find(index);
  if (tile == tiles_.end()) {
    full_ = full_ || tiles_.size() >= most_tiles_;
    if (tiles_.size() >= most_tiles_) return;
    tile = tiles_.try_emplace(index).first;
  }
  const auto column = static_cast<std::size_t>(x - index.x * coverage_tile_cells);
  const auto row = static_cast<std::size_t>(y - index.y * coverage_tile_cells);
  CoverageCell& cell = tile->second.cells.at(row * coverage_tile_cells + column);
  const CoverageCell before = cell;
  const bool newer = before.what == 0 || time > before.last_seen;
  cell.what |= what;
  if (newer || (time == before.last_seen && session < before.session)) {
    cell.last_seen = time;
    cell.session = session;
  }
  const auto [seen, fresh] = tile->second.seen_by.try_emplace(session, time);
  const bool later = time > seen->second;
  if (later) seen->second = time;
  if (fresh || later || !(cell == before)) changed_.insert(index);
}

}  // namespace headframe
