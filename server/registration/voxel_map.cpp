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
  means_.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_) means_.push_back(Float4{voxel.mean.x(), voxel.mean.y(), voxel.mean.z(), 0});
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

/// Squared distances of the means of four voxels from p.
inline Float4 VoxelMap::squared_m(const Mask4& voxels, const Eigen::Vector3f& p) const {
  const auto mean = [&](int lane) { return means_[static_cast<std::size_t>(voxels[lane])]; };
  const Float4 a = mean(0), b = mean(1), c = mean(2), d = mean(3);
  const Float4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Float4 x = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) - p.x();
  const Float4 y = __builtin_shufflevector(ab, cd, 2, 3, 6, 7) - p.y();
  const Float4 z = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 2, 6),
                                           __builtin_shufflevector(c, d, 2, 6, 2, 6), 0, 1, 4, 5) -
                   p.z();
  return x * x + (y * y + z * z);
}

const Voxel* VoxelMap::nearest(const Eigen::Vector3f& p) const {
  Eigen::Vector3i cell;
  if (slots_.empty() || !cell_of(p, 1 / leaf_m_, 0.5F, cell)) return nullptr;
  const Eigen::Vector3i brick = brick_of(cell), local = cell - own * brick;
  const Slot& slot = slots_[slot_of(key_of(brick))];
  if (slot.brick == none) return nullptr;
  const std::uint32_t* first = &bricks_[slot.brick].voxels[offset(local)];
  constexpr int row = edge, layer = edge * edge;
  const auto four = [&](const std::uint32_t* at) {
    return Mask4{static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[row]),
                 static_cast<int>(at[row + 1])};
  };
  // An empty cell is voxel 0, which is far away.
  const Mask4 low = four(first), high = four(first + layer);
  const Float4 squared_low = squared_m(low, p), squared_high = squared_m(high, p);
  const Mask4 is_high = squared_high < squared_low;
  const Float4 squared = is_high ? squared_high : squared_low;
  const Mask4 ids = is_high ? high : low;
  int best = 0;
  for (int lane = 1; lane < 4; ++lane) best = squared[lane] < squared[best] ? lane : best;
  return ids[best] == 0 ? nullptr : &voxels_[static_cast<std::size_t>(ids[best])];
}

}  // namespace headframe
