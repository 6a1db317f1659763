#include "common/cloud/point_cloud.hpp"

#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace headframe {

std::size_t point_count(const KeyframeCloud& cloud) {
  std::size_t n = 0;
  for (const Sweep& sweep : cloud.sweeps) n += sweep.points.size();
  return n;
}

Points finite_points(const Points& points, float min_range_m) {
  Points out;
  out.reserve(points.size());
  for (const auto& p : points)
    if (p.allFinite() && p.squaredNorm() >= min_range_m * min_range_m) out.push_back(p);
  return out;
}

Points voxel_grid(const Points& points, float leaf_m) {
  struct Cell {
    Eigen::Vector3f sum;
    float count;
  };
  constexpr float reach = 1e6F;  // cells each way; 21 bits a coordinate
  std::unordered_map<std::uint64_t, std::size_t> index;
  index.reserve(points.size());
  std::vector<Cell> cells;
  for (const auto& p : points) {
    const Eigen::Vector3f c = (p / leaf_m).array().floor();
    if (!(c.cwiseAbs().maxCoeff() < reach)) continue;
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i)
      key = key << 21 | static_cast<std::uint64_t>(static_cast<std::int64_t>(c[i]) + (1 << 20));
    const auto [it, fresh] = index.try_emplace(key, cells.size());
    if (fresh) cells.push_back({Eigen::Vector3f::Zero(), 0});
    Cell& cell = cells[it->second];
    cell.sum += p;
    cell.count += 1;
  }
  Points out;
  out.reserve(cells.size());
  for (const Cell& cell : cells) out.push_back(cell.sum / cell.count);
  return out;
}

}  // namespace headframe
