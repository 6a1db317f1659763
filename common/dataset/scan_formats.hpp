#pragma once
// The scan formats, from bytes in memory to points. Pure. All points of the file come back, also NaN and zero ones.
// Fails with bad_input; the message gives the line or byte but not the file, which the caller knows. A count in a
// header is checked against the bytes that are there before memory is taken.

#include <string_view>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"

namespace headframe::dataset {

/// The most that a scan file may hold, packed or unpacked: a thousand revolutions of a large lidar would fit.
inline constexpr std::size_t most_scan_bytes = std::size_t{256} << 20;

/// What a file says of each point, as it says it.
struct ScanTable {
  Points points;
  std::vector<float> intensity = {};  // as many, in the units of the file (see IntensityScale); empty: it has none
};

/// KITTI: x y z intensity as float32, nothing else.
Result<ScanTable> parse_kitti(std::string_view bytes);

/// PCD: ascii, binary or binary_compressed, fields in any order; the intensity by its name (see find_intensity).
/// VIEWPOINT is not applied: scans are in the sensor frame.
Result<ScanTable> parse_pcd(std::string_view bytes);

/// PLY: ascii or binary little endian, properties in any order, likewise; the vertices must be the first element.
Result<ScanTable> parse_ply(std::string_view bytes);

}  // namespace headframe::dataset
