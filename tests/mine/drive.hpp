#pragma once
// A robot on a route: where its sensor truly was, and where its odometry believes it was.

#include <vector>

#include "common/geometry/se3.hpp"
#include "tests/mine/ray_caster.hpp"
#include "tests/mine/route.hpp"

namespace headframe::mine {

struct DriveStyle {
  double scan_spacing_m = 2;
  double sensor_height_m = 1;     // over the floor
  double tilt_sigma_rad = 0.017;  // roll and pitch; never beyond 5 deg
  double drift = 1;               // 0: odometry without error; 1: about 0.5 m and 0.4 deg over 150 m
  double frame_yaw_rad = 0;       // heading of the session frame's x axis in the world
};

struct Drive {
  std::vector<Pose> T_world_sensor;  // true
  std::vector<Pose> T_local_sensor;  // as the robot believes; gravity is known, so roll and pitch are true
  Pose T_world_local = Pose::Identity();
};

/// Drives the route and stops for a scan every scan_spacing_m; keeps away from walls where there is room. The local
/// frame's origin is the first pose, its z axis is up. Without drift T_world_local * T_local_sensor is T_world_sensor.
Drive drive_along(const Route& route, const DriveStyle& style, const RayCaster& caster, Rng rng);

}  // namespace headframe::mine
