#pragma once
// Spinning lidars, with the faults real ones have.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "tests/mine/random.hpp"
#include "tests/mine/ray_caster.hpp"

namespace headframe::mine {

/// Angles are from the horizon, up is positive: fov_down_deg of a lidar that looks down is negative.
struct LidarModel {
  std::string name;
  int beams = 32;
  int columns = 256;
  double fov_up_deg = 22.5;
  double fov_down_deg = -22.5;
  double min_range_m = 0.5;
  double max_range_m = 120;
  double range_sigma_m = 0.02;
  double dropout = 0.01;  // share of returns lost anywhere; more at grazing incidence
};

/// os1-32, vlp16-hires, hdl-32e or os0-64; nothing for another name.
std::optional<LidarModel> lidar_model(std::string_view name);

/// A model without noise and dropouts.
LidarModel noiseless(LidarModel model);

struct Scan {
  Points points;                 // sensor frame
  std::vector<float> intensity;  // 0 to 1, as long as points
};

/// One turn of the lidar standing still at the pose. `dust`: expected dust returns per metre of ray near the sensor (0:
/// clean air, 0.01: a haze, 0.05: thick). The same rng gives the same scan. Thread safe.
Scan take_scan(const RayCaster& caster, const LidarModel& model, const Pose& T_world_sensor, double dust, Rng rng);

}  // namespace headframe::mine
