#pragma once
// One scan from a file, by its ending: .bin (KITTI), .pcd or .ply.

#include <filesystem>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"

namespace headframe {

/// Points in the sensor frame. May be empty: a covered lidar sees nothing.
struct Scan {
  Points points;
  std::vector<float> intensity = {};  // as many, as the file says it (see IntensityScale); empty: it has none
  std::size_t dropped = 0;            // NaN, infinite, zero ("no return") or absurdly far points that were left out
};

/// Whether load_scan knows the ending of this name.
bool is_scan_file(const std::filesystem::path& path);

/// Reads one scan. Fails with not_found, unavailable, or bad_input (damaged or over 256 MiB); the message names the
/// file and the line or byte. Thread safe.
Result<Scan> load_scan(const std::filesystem::path& path);

/// Writes points as KITTI .bin, of the intensity 0 where none is given. Replaces the file. Fails with unavailable.
Result<void> write_kitti(const std::filesystem::path& path, const Points& points,
                         const std::vector<float>& intensity = {});

}  // namespace headframe
