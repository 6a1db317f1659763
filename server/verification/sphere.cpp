#include <algorithm>
#include <array>
#include <cmath>

#include "server/support/wide.hpp"
#include "server/verification/prepared_cloud.hpp"

namespace headframe {
namespace {

constexpr std::size_t block = 64;  // points that are moved at once
constexpr int half = 1 << 20;      // cubes on each side of the centre

/// Points of a cloud where its pose puts them, relative to the centre of the sphere, and the cubes they lie in.
struct Moved {
  std::array<float, block> x, y, z, squared_m;
  std::array<int, block> cube_x, cube_y, cube_z;
};

[[gnu::always_inline]] inline int cube_of(float v, float leaf_m) {
  const float cubes = v / leaf_m;
  const int i = static_cast<int>(cubes);
  return i - static_cast<int>(cubes < static_cast<float>(i)) + half;
}

/// `points` has three floats for each point, T has the rows of the transform.
HEADFRAME_WIDE void move(const float* points, std::size_t count, const float* T, float leaf_m, Moved& out) {
  for (std::size_t i = 0; i < count; ++i) {
    const float px = points[3 * i], py = points[3 * i + 1], pz = points[3 * i + 2];
    out.x[i] = T[0] * px + (T[1] * py + T[2] * pz) + T[3];
    out.y[i] = T[4] * px + (T[5] * py + T[6] * pz) + T[7];
    out.z[i] = T[8] * px + (T[9] * py + T[10] * pz) + T[11];
    out.squared_m[i] = out.x[i] * out.x[i] + (out.y[i] * out.y[i] + out.z[i] * out.z[i]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    out.cube_x[i] = cube_of(out.x[i], leaf_m);
    out.cube_y[i] = cube_of(out.y[i], leaf_m);
    out.cube_z[i] = cube_of(out.z[i], leaf_m);
  }
}

/// Remembers which cubes were seen: a bit for each cube of a brick of 4 x 4 x 4, open addressing over the bricks, which
/// are few, so that the table stays in the processor's cache.
class SeenCubes {
 public:
  SeenCubes() : slots_(1024) {}

  bool first(int x, int y, int z) {
    const std::uint64_t key = std::uint64_t{static_cast<std::uint32_t>(x >> 2)} << 42 |
                              std::uint64_t{static_cast<std::uint32_t>(y >> 2)} << 21 |
                              static_cast<std::uint32_t>(z >> 2);
    const std::uint64_t cube = std::uint64_t{1} << ((x & 3) | (y & 3) << 2 | (z & 3) << 4);
    Slot* slot = &slots_[slot_of(key)];
    if (slot->cubes == 0) {
      if (2 * ++used_ > slots_.size()) {
        grow();
        slot = &slots_[slot_of(key)];
      }
      slot->key = key;
    }
    const bool fresh = (slot->cubes & cube) == 0;
    slot->cubes |= cube;
    return fresh;
  }

 private:
  struct Slot {
    std::uint64_t key = 0, cubes = 0;  // no cubes: empty
  };
  std::size_t slot_of(std::uint64_t key) const {
    std::size_t at = (key * 0x9E3779B97F4A7C15U) >> 40 & (slots_.size() - 1);
    while (slots_[at].cubes != 0 && slots_[at].key != key) at = (at + 1) & (slots_.size() - 1);
    return at;
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.cubes != 0) slots_[slot_of(slot.key)] = slot;
  }
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
};

}  // namespace

SurfelCloud sphere(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double radius_m, float leaf_m) {
  constexpr double sight_m = 12;  // clouds from farther out add little to the sphere but noise
  SurfelCloud out;
  SeenCubes seen;
  Moved moved;
  const auto r2 = static_cast<float>(radius_m * radius_m);
  // The nearest clouds first: where several see a cube, the best view of it stays.
  std::vector<std::pair<double, const PlacedCloud*>> near;
  for (const PlacedCloud& c : clouds)
    if (const double d = (c.T_local_sensor.translation() - centre).norm(); d < radius_m + sight_m)
      near.emplace_back(d, &c);
  std::stable_sort(near.begin(), near.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  for (const auto& [distance, c] : near) {
    // Relative to the centre: float keeps its precision however far a session has come.
    Eigen::Matrix<float, 3, 4, Eigen::RowMajor> T;
    T << c->T_local_sensor.linear().cast<float>(), (c->T_local_sensor.translation() - centre).cast<float>();
    const Eigen::Matrix3f R = T.leftCols<3>();
    const Eigen::Vector3f origin = centre.cast<float>();
    const Points& points = c->cloud->points;
    for (std::size_t begin = 0; begin < points.size(); begin += block) {
      const std::size_t count = std::min(block, points.size() - begin);
      move(points[begin].data(), count, T.data(), leaf_m, moved);
      for (std::size_t i = 0; i < count; ++i) {
        if (moved.squared_m[i] > r2 || !seen.first(moved.cube_x[i], moved.cube_y[i], moved.cube_z[i])) continue;
        out.points.push_back(Eigen::Vector3f(moved.x[i], moved.y[i], moved.z[i]) + origin);
        out.normals.push_back(R * c->cloud->normals[begin + i]);
      }
    }
  }
  return out;
}

}  // namespace headframe
