#include "tests/mine/overlap.hpp"

#include <algorithm>
#include <cmath>

namespace headframe::mine {

void SeenVoxels::add(const Points& points, const Pose& T_world_sensor, double max_range_m) {
  for (const auto& p : points) {
    if (p.squaredNorm() > max_range_m * max_range_m) continue;
    const Eigen::Vector3d q = T_world_sensor * p.cast<double>() / voxel_m_;
    const auto bits = [](double v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v))) & 0x1fffffU;
    };
    voxels_.insert(bits(q.x()) << 42 | bits(q.y()) << 21 | bits(q.z()));
  }
}

double overlap_pct(const SeenVoxels& a, const SeenVoxels& b) {
  const SeenVoxels& small = a.size() < b.size() ? a : b;
  const SeenVoxels& large = a.size() < b.size() ? b : a;
  if (small.size() == 0) return 0;
  const auto both = std::count_if(small.voxels_.begin(), small.voxels_.end(),
                                  [&](std::uint64_t v) { return large.voxels_.contains(v); });
  return 100.0 * static_cast<double>(both) / static_cast<double>(small.size());
}

}  // namespace headframe::mine
