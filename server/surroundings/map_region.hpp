#pragma once
// Merges the points of many keyframes in one region.

#include <functional>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "common/result.hpp"
#include "common/session/map_question.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Limits of one map.
struct MapLimits {
  double radius_m = 200;  // of a sphere; a box may be twice as long
  double least_resolution_m = 0.05, most_resolution_m = 5;
  std::size_t clouds = 400;     // number of clouds read for it; the newest are used
  std::size_t points = 250000;  // in the map
  double reach_m = 20;          // clouds of keyframes this far outside the region are used too
};

/// Why no map of this region is possible; empty: it may be possible.
std::string objection(const Region& region, double resolution_m, const MapLimits& limits);

Eigen::Vector3d middle_m(const Region& region);
/// Distance of a point from the region; 0 inside.
double distance_m(const Region& region, const Eigen::Vector3d& p_m);

struct RegionCloud {
  KeyframeRef keyframe;
  double stamp_s = 0;
  Pose T_region_sensor = Pose::Identity();  // the region's frame
};

/// The clouds near the region, newest first, at most limits.clouds. left_out: the number of further ones.
std::vector<RegionCloud> clouds_near(std::vector<RegionCloud> all, const Region& region, const MapLimits& limits,
                                     std::size_t& left_out);

struct FusedPoints {
  Points points;  // relative to middle_m, along the axes of the region's frame; the mean of the points in each cube
  std::size_t clouds = 0;
};
/// invalid_argument: more than limits.points. `read` returns a keyframe's cloud in its sensor frame; clouds that cannot
/// be read are left out. `stop` is called between clouds; if it returns true, fuse fails with unavailable.
/// Deterministic.
Result<FusedPoints> fuse(const std::vector<RegionCloud>& clouds, const Region& region, double resolution_m,
                         const MapLimits& limits, const std::function<Result<KeyframeCloud>(const KeyframeRef&)>& read,
                         const std::function<bool()>& stop);

}  // namespace headframe
