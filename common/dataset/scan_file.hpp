#pragma once
// Reads one scan from a file, by its extension: .bin (KITTI), .pcd or .ply.

#include <filesystem>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"

namespace headframe {

/// Points in the sensor frame. May be empty, for example if the lidar is covered.
struct Scan {
  Points points;
  std::vector<float> intensity = {};  // one for each point, in the file's units (IntensityScale); empty: none
  std::size_t dropped = 0;            // points that were left out: NaN, infinite, zero (no return) or absurdly far
};

/// Whether load_scan supports the extension of this name.
bool is_scan_file(const std::filesystem::path& path);

/// Reads one scan. Fails with not_found, unavailable, or bad_input (damaged, or larger than 256 MiB); the message names
/// the file and the line or byte. Thread safe.
Result<Scan> load_scan(const std::filesystem::path& path);

/// Writes points as KITTI .bin, with intensity 0 if none is given. Replaces the file. Fails with unavailable.
Result<void> write_kitti(const std::filesystem::path& path, const Points& points,
                         const std::vector<float>& intensity = {});

}  // namespace headframe
