#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
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

/// Surfels averaged over cubes of leaf_m, of a submap: a few hundred leaves wide. Built without neighbour search. The
/// same surfels in the same order give the same map. Queries are thread safe.
class VoxelMap {
 public:
  VoxelMap() = default;

  /// Points and unit normals in one frame, one normal for each point; leaf_m > 0. Points that are not finite, more than
  /// a million leaves from the origin, or more than 500 from the first point on an axis are ignored.
  VoxelMap(const Points& points, const Points& normals, float leaf_m);

  /// Of the eight voxels whose centres surround p, the one with the nearest mean. A voxel mean within half a leaf of p
  /// is always found; the result is never farther than 1.5 leaves on an axis. Null if all eight are empty.
  const Voxel* nearest(const Eigen::Vector3f& p) const;

  /// The same of many points, faster than one by one; one answer for each.
  void nearest(std::span<const Eigen::Vector3f> points, std::span<const Voxel*> answers) const;

  float leaf_m() const { return leaf_m_; }
  std::size_t bytes() const {
    return voxels_.capacity() * sizeof(Voxel) + means_.capacity() * sizeof(Float4) +
           bricks_.capacity() * sizeof(Brick) + brick_at_.capacity() * sizeof(std::uint32_t);
  }

  /// In the order of their first points.
  std::span<const Voxel> voxels() const { return std::span(voxels_).subspan(1); }

 private:
  /// Voxels are stored in bricks of 4 x 4 x 4, plus the next layer on the far sides, so that eight neighbours always
  /// lie in one brick.
  static constexpr int own = 4, edge = own + 1;
  struct Brick {
    std::array<std::uint32_t, edge * edge * edge> voxels{};  // 0: empty
  };

  void lay_out(const std::vector<Eigen::Vector3i>& cells);
  std::pair<Eigen::Vector3i, Eigen::Vector3i> place_of(const Eigen::Vector3i& cell) const;
  std::uint32_t& voxel_at(const Eigen::Vector3i& cell);
  void share(const Eigen::Vector3i& cell, std::uint32_t voxel);
  static std::size_t offset(int x, int y, int z);   // of a cell within its brick
  std::size_t index_of(int x, int y, int z) const;  // of a brick within the grid
  Brick& brick(const Eigen::Vector3i& at);
  Float4 squared_m(const Mask4& voxels, const Eigen::Vector3f& p) const;
  const Voxel* look_up(const Eigen::Vector3f& p) const;

  float leaf_m_ = 1;
  std::vector<Voxel> voxels_;  // the first one is a dummy for empty cells, far away
  std::vector<Float4> means_;  // of voxels_, packed for nearest()
  std::vector<Brick> bricks_;  // the first one is empty
  // A grid of bricks around all voxels; of each its number in bricks_.
  std::vector<std::uint32_t> brick_at_;
  Mask4 low_{};                // first cell of the grid
  Float4 low_cell_{}, end_{};  // the same, and the first one beyond it
  int bricks_x_ = 0, bricks_y_ = 0;
};

}  // namespace headframe
