#include "server/place/session_walls.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

constexpr float cell_m = 0.5F;
constexpr double piece_m = 120, level_reach_m = 10, level_height_m = 4, widest_m = 500;

std::vector<double> path_to_each(std::span<const Keyframe> keyframes) {
  std::vector<double> path(keyframes.size(), 0);
  for (std::size_t i = 1; i < path.size(); ++i)
    path[i] = path[i - 1] + (position(keyframes[i]) - position(keyframes[i - 1])).norm();
  return path;
}

bool fits(std::span<const Keyframe> level, const Eigen::Vector3d& p) {
  return std::all_of(level.begin(), level.end(), [&](const Keyframe& k) {
    const Eigen::Vector3d d = position(k) - p;
    const bool above = d.head<2>().norm() < level_reach_m && std::abs(d.z()) > level_height_m;
    return !above && d.head<2>().norm() < widest_m;
  });
}

}  // namespace

std::vector<Piece> cut_pieces(std::span<const Keyframe> keyframes, double length_m) {
  const std::vector<double> path = path_to_each(keyframes);
  std::vector<Piece> pieces;
  const auto index = [&](double at) {
    return static_cast<std::size_t>(std::lower_bound(path.begin(), path.end(), at) - path.begin());
  };
  for (double at = 0; !keyframes.empty(); at += length_m / 2) {
    pieces.push_back({index(at), std::min(keyframes.size(), index(at + length_m) + 1)});
    if (pieces.back().end == keyframes.size()) break;
  }
  return pieces;
}

std::vector<Piece> cut_levels(std::span<const Keyframe> keyframes) {
  std::vector<Piece> levels;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    if (!levels.empty() &&
        fits(keyframes.subspan(levels.back().begin, levels.back().end - levels.back().begin), position(keyframes[i])))
      levels.back().end = i + 1;
    else
      levels.push_back({i, i + 1});
  }
  return levels;
}

SessionWalls::SessionWalls(std::span<const Keyframe> keyframes) : path_m(headframe::path_m(keyframes)) {
  for (const Piece& level : cut_levels(keyframes)) {
    const auto within = keyframes.subspan(level.begin, level.end - level.begin);
    WallMap map = draw_wall_map(within, cell_m);
    WallField field(map);
    std::vector<Part> parts;
    for (const Piece& p : cut_pieces(within, piece_m))
      parts.push_back({{level.begin + p.begin, level.begin + p.end},
                       draw_wall_map(within.subspan(p.begin, p.end - p.begin), cell_m)});
    levels.push_back({level, std::move(map), std::move(field), std::move(parts)});
  }
}

std::size_t SessionWalls::bytes() const {
  const auto of = [](const WallMap& map) {
    return (map.walls.capacity() + map.free.capacity()) * sizeof(map.walls[0]);
  };
  std::size_t bytes = 0;
  for (const Level& level : levels) {
    bytes += of(level.map) + level.field.bytes();
    for (const Part& part : level.parts) bytes += of(part.map);
  }
  return bytes;
}

double path_m(std::span<const Keyframe> keyframes) {
  const auto path = path_to_each(keyframes);
  return path.empty() ? 0 : path.back();
}

}  // namespace headframe
