#pragma once
// What a network learns from: many scans of one mine, by several lidars, and which of them see the same rock.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/descriptor/range_image.hpp"
#include "common/result.hpp"
#include "tests/mine/scenario.hpp"

namespace headframe::mine {

struct View {
  Eigen::Vector3f place_m = Eigen::Vector3f::Zero();  // world
  float yaw_rad = 0;                                  // heading of the levelled sensor frame in the world
  int sensor = 0;                                     // index into view_sensors
  int ways = 0;                                       // open_directions()
  int drive = 0;
  RangeImage image;  // holes filled as the family `learned` fills them
};

/// Two views and the share of the rock within 20 m that both see, over the smaller, in percent; 1 m cubes.
struct ViewPair {
  int a = 0;
  int b = 0;
  int overlap_pct = 0;
};

struct Views {
  std::vector<View> views;
  std::vector<ViewPair> pairs;  // those within 25 m of each other that share something; a < b
};

/// Drives `routes` random ways through the mine, each twice: by lidars, at heights, in dust and with tilts of their
/// own, the second time half of them the other way round. Deterministic by seed.
Views take_views(Kind kind, std::uint64_t seed, int routes, double length_m, double spacing_m);

/// One little-endian file: "HFV1"; uint32 views, rows, columns, pairs; per view float32 x, y, z, yaw and int32 sensor,
/// ways, drive; per view rows x columns int16, 1000 times the first plane of log_range_and_mask (-32768: no range); per
/// pair int32 a, b, overlap.
Result<void> write_views(const Views& views, const std::filesystem::path& file);

}  // namespace headframe::mine
