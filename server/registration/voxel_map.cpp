#include "server/registration/voxel_map.hpp"

#include <cmath>

namespace headframe {
namespace {

constexpr float farthest_cell = 1e6F;
constexpr std::uint64_t key_x = 1, key_y = 1ULL << 21, key_z = 1ULL << 42, bias = 1ULL << 20;

/// Neighbours along an axis differ by key_x, key_y, key_z.
std::uint64_t key_of(const Eigen::Vector3f& cell) {
  const auto part = [](float v) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(v)) + bias; };
  return part(cell.x()) * key_x + part(cell.y()) * key_y + part(cell.z()) * key_z;
}

Eigen::Vector3f floored(const Eigen::Vector3f& v) { return v.array().floor(); }

}  // namespace

VoxelMap::VoxelMap(const Points& points, const Points& normals, float leaf_m) : leaf_m_(leaf_m), slots_(1024) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f cell = floored(points[i] / leaf_m_);
    if (!(cell.cwiseAbs().maxCoeff() < farthest_cell)) continue;
    const std::uint64_t key = key_of(cell);
    Slot& slot = slots_[slot_of(key)];
    if (slot.voxel == empty) {
      slot = {key, static_cast<std::uint32_t>(voxels_.size())};
      voxels_.emplace_back();
    }
    Voxel& voxel = voxels_[slot.voxel];
    voxel.mean += points[i];
    const Symmetric3f N = outer(normals[i]);
    for (std::size_t k = 0; k < N.size(); ++k) voxel.N[k] += N[k];
    voxel.count += 1;
    if (2 * voxels_.size() > slots_.size()) grow();
  }
  for (Voxel& voxel : voxels_) {
    voxel.mean /= voxel.count;
    for (float& n : voxel.N) n /= voxel.count;
  }
}

std::size_t VoxelMap::slot_of(std::uint64_t key) const {
  const std::uint64_t mixed = key * 0x9E3779B97F4A7C15ULL;
  std::size_t at = (mixed >> 32) & (slots_.size() - 1);
  while (slots_[at].voxel != empty && slots_[at].key != key) at = (at + 1) & (slots_.size() - 1);
  return at;
}

void VoxelMap::grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  for (const Slot& slot : old)
    if (slot.voxel != empty) slots_[slot_of(slot.key)] = slot;
}

const Voxel* VoxelMap::nearest(const Eigen::Vector3f& p) const {
  const Eigen::Vector3f cell = floored(p / leaf_m_ - Eigen::Vector3f::Constant(0.5F));
  if (!(cell.cwiseAbs().maxCoeff() < farthest_cell) || voxels_.empty()) return nullptr;
  const std::uint64_t first = key_of(cell);
  const Voxel* best = nullptr;
  float least = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const std::uint64_t key = first + (corner & 1U) * key_x + (corner >> 1U & 1U) * key_y + (corner >> 2U) * key_z;
    const Slot& slot = slots_[slot_of(key)];
    if (slot.voxel == empty) continue;
    const Voxel& voxel = voxels_[slot.voxel];
    const float squared_m = (voxel.mean - p).squaredNorm();
    if (best && squared_m >= least) continue;
    best = &voxel;
    least = squared_m;
  }
  return best;
}

}  // namespace headframe
