#pragma once
// A whole recording: several robots in one mine, with as much overlap as asked for.

#include <string>
#include <vector>

#include "common/result.hpp"
#include "tests/mine/drive.hpp"
#include "tests/mine/lidar.hpp"
#include "tests/mine/overlap.hpp"

namespace headframe::mine {

/// Rock to cast rays at, and the plans (one per region) it was made of. Regions are not connected.
struct World {
  std::vector<Plan> regions;
  RayCaster caster;
};

World build_world(std::vector<Plan> regions);

struct Robot {
  std::string name;
  LidarModel lidar;
  DriveStyle style = {};
  double dust = 0;
  Route route = {};
};

struct Request {
  Kind kind = Kind::junctions;
  std::uint64_t seed = 1;
  int robots = 2;
  double overlap_pct = 30;  // of each robot with the one before; 0: no two robots see the same rock
  double length_m = 100;    // of each drive
  double scan_spacing_m = 2;
  std::vector<std::string> sensors{"os1-32"};  // given out in turn
  double drift = 1;
  double dust = 0;
};

struct Scenario {
  World world;
  std::vector<Robot> robots;  // named r1, r2, ...
};

/// The same request gives the same scenario. Fails (invalid_argument) on an unknown sensor or numbers out of range.
Result<Scenario> make_scenario(const Request& request);

/// A drive with all its scans, ready to be written or played.
struct Recording {
  Robot robot;
  Drive drive;
  std::vector<Scan> scans;
};

/// Drives the robot's route and scans on all cores. Deterministic by seed.
Recording record(const World& world, const Robot& robot, std::uint64_t seed);

/// What a recording saw within max_range_m.
SeenVoxels seen(const Recording& recording, double voxel_m, double max_range_m);

}  // namespace headframe::mine
