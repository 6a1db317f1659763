#pragma once
// How much of the same rock two robots saw.

#include <cstdint>
#include <unordered_set>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe::mine {

/// The cubes of space in which a robot saw a surface.
class SeenVoxels {
 public:
  explicit SeenVoxels(double voxel_m) : voxel_m_(voxel_m) {}

  /// Adds the points nearer to the sensor than max_range_m.
  void add(const Points& points, const Pose& T_world_sensor, double max_range_m);
  std::size_t size() const { return voxels_.size(); }

  /// Share of the voxels that both saw, over the smaller of the two, in percent; 0 when either is empty.
  friend double overlap_pct(const SeenVoxels& a, const SeenVoxels& b);

 private:
  double voxel_m_;
  std::unordered_set<std::uint64_t> voxels_;
};

double overlap_pct(const SeenVoxels& a, const SeenVoxels& b);

}  // namespace headframe::mine
