#pragma once
// The points of many keyframes in one region, fused.

#include <functional>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "common/result.hpp"
#include "common/session/map_question.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// What one map may take.
struct MapLimits {
  double radius_m = 200;  // of a sphere; twice as much along a box
  double least_resolution_m = 0.05, most_resolution_m = 5;
  std::size_t clouds = 400;     // that are read for it, the newest
  std::size_t points = 250000;  // of the map
  double reach_m = 20;          // clouds from so far outside the region are read too
};

/// Why there is no map of this region; empty: there may be.
std::string objection(const Region& region, double resolution_m, const MapLimits& limits);

Eigen::Vector3d middle_m(const Region& region);
/// How far a point is from the region; 0 within.
double distance_m(const Region& region, const Eigen::Vector3d& p_m);

struct RegionCloud {
  KeyframeRef keyframe;
  double stamp_s = 0;
  Pose T_region_sensor = Pose::Identity();  // the region's frame
};

/// Of these the ones near the region, the newest first, at most limits.clouds. left_out: how many more there are.
std::vector<RegionCloud> clouds_near(std::vector<RegionCloud> all, const Region& region, const MapLimits& limits,
                                     std::size_t& left_out);

struct FusedPoints {
  Points points;  // from middle_m on, along the axes of the region's frame: the mean of each cube's points
  std::size_t clouds = 0;
};
/// invalid_argument: more than limits.points. `read` gives a keyframe's cloud in its sensor's frame; one that can not
/// be read is left out. `stop` is asked between clouds; true: unavailable. Deterministic.
Result<FusedPoints> fuse(const std::vector<RegionCloud>& clouds, const Region& region, double resolution_m,
                         const MapLimits& limits, const std::function<Result<KeyframeCloud>(const KeyframeRef&)>& read,
                         const std::function<bool()>& stop);

}  // namespace headframe
