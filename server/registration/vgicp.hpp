#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/registration/registration.hpp"
#include "server/registration/voxel_map.hpp"

namespace headframe {

struct VgicpLevel {
  float leaf_m = 1;
  std::size_t source_points = 1000;  // limit; spread evenly over the source
};

struct VgicpConfig {
  std::vector<VgicpLevel> levels{{2.0F, 1000}, {1.0F, 2000}, {0.5F, 6000}};  // coarse to fine
  int iterations = 8;          // limit for each level; right placements take 2 or 3
  double least_inliers = 0.1;  // share of the level's source points
  double degenerate_below = 0.012;
  double gravity_stiffness = 0.5;  // of a spring that keeps z along gravity until the last level; 0: none
  FactorModel factor;
  int threads = 1;
};

/// A target prepared for VGICP: one voxel map for each level of its configuration.
using VoxelMaps = std::vector<VoxelMap>;
VoxelMaps make_voxel_maps(const Points& points, const Points& normals, const VgicpConfig& config = {});

/// Voxelized GICP (Koide et al., ICRA 2021), coarse to fine: the partner of a source point is the nearest of the voxels
/// around it, so no tree search is needed. Geman-McClure weights; partners whose normals differ by more than 60 deg are
/// ignored; a spring keeps z along gravity until the last level. Levels without a map of their leaf size are skipped.
/// One unit normal for each point. The result does not depend on the number of threads. Thread safe.
Registration align(const VoxelMaps& target, const Points& source, const Points& source_normals,
                   const Pose& T_target_source_0, const VgicpConfig& config = {});

/// A submap and the target that it is registered on. Not owned; one unit normal for each point.
struct VgicpPair {
  const VoxelMaps* target = nullptr;
  const Points* source = nullptr;
  const Points* normals = nullptr;
};

/// One transform for several pairs at once, as if they were one map; they share a level's number of source points.
Registration align(std::span<const VgicpPair> pairs, const Pose& T_target_source_0, const VgicpConfig& config);

/// How far the points lie off the target's surfaces where they are: Registration::rmse_m without a registration.
double scatter_m(const VoxelMaps& target, const Points& points, const Points& normals, const VgicpConfig& config = {});

/// Selects at most `most` of `count` points, scattered like a Weyl sequence so that the selection does not align with
/// the rings of a lidar.
std::vector<std::uint32_t> scattered(std::size_t count, std::size_t most);

}  // namespace headframe
