#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/registration/normal_equations.hpp"
#include "server/support/simd.hpp"

namespace headframe {

/// The surface in a voxel: the mean of its points, and the mean of the outer products of their normals. For a flat
/// piece of wall N = n n^T; the more the surface bends, the less N favours one direction.
struct Voxel {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  float count = 0;
  Symmetric3f N{};
};

/// Surfels averaged over cubes of leaf_m. Built in one pass without neighbour search. The same surfels in the same
/// order give the same map. Queries are thread safe.
class VoxelMap {
 public:
  VoxelMap() = default;

  /// Points and unit normals in one frame, one normal for each point; leaf_m > 0. Points that are not finite or more
  /// than a million leaves from the origin are ignored.
  VoxelMap(const Points& points, const Points& normals, float leaf_m);

  /// Of the eight voxels whose centres surround p, the one with the nearest mean. A voxel mean within half a leaf of p
  /// is always found; the result is never farther than 1.5 leaves on an axis. Null if all eight are empty.
  const Voxel* nearest(const Eigen::Vector3f& p) const;

  float leaf_m() const { return leaf_m_; }
  std::size_t bytes() const {
    return voxels_.capacity() * sizeof(Voxel) + means_.capacity() * sizeof(Float4) +
           bricks_.capacity() * sizeof(Brick) + slots_.capacity() * sizeof(Slot);
  }

  /// In the order of their first points.
  std::span<const Voxel> voxels() const { return std::span(voxels_).subspan(1); }

 private:
  /// Voxels are stored in bricks of 4 x 4 x 4, plus the next layer on the far sides, so that eight neighbours always
  /// lie in one brick and a single hash lookup finds them.
  static constexpr int own = 4, edge = own + 1;
  struct Brick {
    std::array<std::uint32_t, edge * edge * edge> voxels{};  // 0: empty
  };
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t brick = none;
  };
  static constexpr std::uint32_t none = 0xFFFFFFFF;

  Float4 squared_m(const Mask4& voxels, const Eigen::Vector3f& p) const;
  static std::size_t offset(const Eigen::Vector3i& local);  // of a cell within its brick
  std::uint32_t& voxel_at(const Eigen::Vector3i& cell);
  void share(const Eigen::Vector3i& cell, std::uint32_t voxel);
  Brick& brick_at(const Eigen::Vector3i& brick);
  std::size_t slot_of(std::uint64_t key) const;
  void grow();

  float leaf_m_ = 1;
  std::vector<Voxel> voxels_;  // the first one is a dummy for empty cells, far away
  std::vector<Float4> means_;  // of voxels_, packed for nearest()
  std::vector<Brick> bricks_;
  std::vector<Slot> slots_;  // open addressing, a power of two, at most half full
};

}  // namespace headframe
