#include "server/registration/voxel_map.hpp"

namespace headframe {
namespace {

constexpr float farthest_cell = 1e6F;
constexpr float far_away = 1e18F;  // its square still fits a float

int floored(float v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(v < static_cast<float>(i));
}

/// Returns false if p is not finite or too far away.
bool cell_of(const Eigen::Vector3f& p, float per_m, float shift, Eigen::Vector3i& cell) {
  for (int a = 0; a < 3; ++a) {
    const float v = p[a] * per_m - shift;
    if (!(v > -farthest_cell && v < farthest_cell)) return false;
    cell[a] = floored(v);
  }
  return true;
}

Eigen::Vector3i brick_of(const Eigen::Vector3i& cell) { return {cell.x() >> 2, cell.y() >> 2, cell.z() >> 2}; }

std::uint64_t key_of(const Eigen::Vector3i& brick) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(v) + (1U << 20U); };
  return part(brick.x()) | part(brick.y()) << 21U | part(brick.z()) << 42U;
}

}  // namespace

std::size_t VoxelMap::offset(const Eigen::Vector3i& local) {
  const int at = (local.z() * edge + local.y()) * edge + local.x();
  return static_cast<std::size_t>(at);
}

VoxelMap::VoxelMap(const Points& points, const Points& normals, float leaf_m)
    : leaf_m_(leaf_m), voxels_(1), slots_(256) {
  voxels_[0].mean.setConstant(far_away);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector3i cell;
    if (!cell_of(points[i], 1 / leaf_m_, 0, cell)) continue;
    std::uint32_t id = voxel_at(cell);
    if (id == 0) {
      id = static_cast<std::uint32_t>(voxels_.size());
      voxels_.emplace_back();
      share(cell, id);
    }
    Voxel& voxel = voxels_[id];
    voxel.mean += points[i];
    const Symmetric3f N = outer(normals[i]);
    for (std::size_t k = 0; k < N.size(); ++k) voxel.N[k] += N[k];
    voxel.count += 1;
  }
  for (Voxel& voxel : voxels_) {
    if (voxel.count == 0) continue;
    voxel.mean /= voxel.count;
    for (float& n : voxel.N) n /= voxel.count;
  }
}

std::uint32_t& VoxelMap::voxel_at(const Eigen::Vector3i& cell) {
  const Eigen::Vector3i brick = brick_of(cell), local = cell - own * brick;
  return brick_at(brick).voxels[offset(local)];
}

/// Writes the voxel into its own brick and into the preceding ones that contain it as their next layer.
void VoxelMap::share(const Eigen::Vector3i& cell, std::uint32_t voxel) {
  const Eigen::Vector3i brick = brick_of(cell), local = cell - own * brick;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i back(corner & 1, corner >> 1 & 1, corner >> 2);
    if ((back.array() > 0 && local.array() > 0).any()) continue;
    const Eigen::Vector3i at = local + own * back;
    brick_at(brick - back).voxels[offset(at)] = voxel;
  }
}

VoxelMap::Brick& VoxelMap::brick_at(const Eigen::Vector3i& brick) {
  const std::uint64_t key = key_of(brick);
  std::size_t at = slot_of(key);
  if (slots_[at].brick == none) {
    if (2 * bricks_.size() >= slots_.size()) {
      grow();
      at = slot_of(key);
    }
    slots_[at] = {key, static_cast<std::uint32_t>(bricks_.size())};
    bricks_.emplace_back();
  }
  return bricks_[slots_[at].brick];
}

std::size_t VoxelMap::slot_of(std::uint64_t key) const {
  const std::uint64_t mixed = key * 0x9E3779B97F4A7C15ULL;
  std::size_t at = (mixed >> 40U) & (slots_.size() - 1);
  while (slots_[at].brick != none && slots_[at].key != key) at = (at + 1) & (slots_.size() - 1);
  return at;
}

void VoxelMap::grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  for (const Slot& slot : old)
    if (slot.brick != none) slots_[slot_of(slot.key)] = slot;
}

const Voxel* VoxelMap::nearest(const Eigen::Vector3f& p) const {
  Eigen::Vector3i cell;
  if (slots_.empty() || !cell_of(p, 1 / leaf_m_, 0.5F, cell)) return nullptr;
  const Eigen::Vector3i brick = brick_of(cell), local = cell - own * brick;
  const Slot& slot = slots_[slot_of(key_of(brick))];
  if (slot.brick == none) return nullptr;
  const std::uint32_t* first = &bricks_[slot.brick].voxels[offset(local)];
  const Voxel* best = voxels_.data();
  float least = (best->mean - p).squaredNorm();
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x) {
        const Voxel* voxel = &voxels_[first[(z * edge + y) * edge + x]];
        const float squared_m = (voxel->mean - p).squaredNorm();
        best = squared_m < least ? voxel : best;
        least = std::min(least, squared_m);
      }
  return best == voxels_.data() ? nullptr : best;
}

}  // namespace headframe
