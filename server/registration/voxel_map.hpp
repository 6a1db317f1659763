#pragma once

#include <cstdint>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/registration/normal_equations.hpp"

namespace headframe {

/// What a voxel knows of the surface in it: the mean of its points, and the mean of the outer products of their
/// normals. A flat piece of wall has N = n n^T; the more it bends, the less N claims to know any direction.
struct Voxel {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  Symmetric3f N{};
  float count = 0;
};

/// Surfels summed up by cubes of leaf_m, found by hashing. One pass to build, no neighbour search. The same surfels in
/// the same order give the same map. Queries are thread safe.
class VoxelMap {
 public:
  VoxelMap() = default;

  /// Points and unit normals of one frame, one normal a point; leaf_m > 0. Points that are not finite or lie more than
  /// a million leaves from the origin are left out.
  VoxelMap(const Points& points, const Points& normals, float leaf_m);

  /// The voxel whose mean is nearest, of the eight whose centres surround p: it is found when one lies within half a
  /// leaf, and is never farther than 1.5 leaves on an axis. Null when all eight are empty.
  const Voxel* nearest(const Eigen::Vector3f& p) const;

  float leaf_m() const { return leaf_m_; }
  const std::vector<Voxel>& voxels() const { return voxels_; }  // in the order of their first points

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t voxel = empty;
  };
  static constexpr std::uint32_t empty = 0xFFFFFFFF;
  std::size_t slot_of(std::uint64_t key) const;
  void grow();

  float leaf_m_ = 1;
  std::vector<Voxel> voxels_;
  std::vector<Slot> slots_;  // open addressing, a power of two, at most half full
};

}  // namespace headframe
