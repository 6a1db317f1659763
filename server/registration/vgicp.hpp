#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/registration/registration.hpp"
#include "server/registration/voxel_map.hpp"

namespace headframe {

struct VgicpLevel {
  float leaf_m = 1;
  std::size_t source_points = 1000;  // at most; spread evenly over the source
};

struct VgicpConfig {
  std::vector<VgicpLevel> levels{{2.0F, 1000}, {1.0F, 2000}, {0.5F, 6000}};  // coarse to fine
  int iterations = 15;                                                       // at most, in each level
  double least_inliers = 0.1;                                                // of the level's source points
  double degenerate_below = 0.012;
  double gravity_stiffness = 0.5;  // of the spring that keeps z along gravity until the last level; 0: none
  FactorModel factor;
  int threads = 1;
};

/// A target ready for VGICP: one voxel map for each level of the config it was made with.
using VoxelMaps = std::vector<VoxelMap>;
VoxelMaps make_voxel_maps(const Points& points, const Points& normals, const VgicpConfig& config = {});

/// Voxelized GICP (Koide et al., ICRA 2021) coarse to fine: a source point's partner is the nearest of the voxels
/// around it, so no tree is searched. Same kernel, gravity, result and promises as align() of gicp.hpp: some times
/// quicker, and a few centimetres less exact. Levels without a map of their leaf size are left out. One unit normal a
/// point. Thread safe.
Registration align(const VoxelMaps& target, const Points& source, const Points& source_normals,
                   const Pose& T_target_source_0, const VgicpConfig& config = {});

/// A submap and what it is laid on. Not owned; one unit normal a point.
struct VgicpPair {
  const VoxelMaps* target = nullptr;
  const Points* source = nullptr;
  const Points* normals = nullptr;
};

/// One T for several pairs at once, as if they were one map; a level's source points are shared out between them.
Registration align(std::span<const VgicpPair> pairs, const Pose& T_target_source_0, const VgicpConfig& config);

/// Which of `count` points to take so that at most `most` remain: scattered like a Weyl sequence, so that it does not
/// fall in step with the rings of a lidar.
std::vector<std::uint32_t> scattered(std::size_t count, std::size_t most);

}  // namespace headframe
