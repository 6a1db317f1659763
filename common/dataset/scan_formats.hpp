#pragma once
// Parsers of the scan formats. Pure. They return all points of the file, including NaN and zeros. bad_input: the
// message gives the line or byte but not the file, which the caller knows. A count in a header is checked against the
// available bytes before memory is allocated.

#include <string_view>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"

namespace headframe::dataset {

/// Size limit of a scan file, packed or unpacked; about a thousand revolutions of a large lidar.
inline constexpr std::size_t most_scan_bytes = std::size_t{256} << 20;

/// The content of a file as it is.
struct ScanTable {
  Points points;
  std::vector<float> intensity = {};  // one for each point, in the file's units (IntensityScale); empty: none
};

/// KITTI: x y z intensity as float32, nothing else.
Result<ScanTable> parse_kitti(std::string_view bytes);

/// PCD: ascii, binary or binary_compressed, fields in any order; the intensity is found by name (find_intensity).
/// VIEWPOINT is not applied: scans are in the sensor frame.
Result<ScanTable> parse_pcd(std::string_view bytes);

/// PLY: ascii or binary little endian, properties in any order; the vertices must be the first element.
Result<ScanTable> parse_ply(std::string_view bytes);

}  // namespace headframe::dataset
