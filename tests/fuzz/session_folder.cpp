// The readers of recorded sessions.
#include "common/dataset/lzf.hpp"
#include "common/dataset/poses_file.hpp"
#include "common/dataset/scan_formats.hpp"
#include "common/dataset/sensor_file.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  auto bytes = fuzz::text(data, size);
  switch (fuzz::take_byte(bytes) % 6) {
    case 0:
      if (const auto points = dataset::parse_pcd(bytes); points) fuzz::require(points->points.size() <= 88 * size);
      break;
    case 1:
      if (const auto points = dataset::parse_ply(bytes); points) fuzz::require(points->points.size() <= size);
      break;
    case 2:
      if (const auto points = dataset::parse_kitti(bytes); points)
        fuzz::require(points->points.size() == bytes.size() / 16);
      break;
    case 3:
      if (const auto poses = dataset::parse_poses(bytes); poses)
        for (const auto& pose : *poses) fuzz::require(pose.T_local_sensor.matrix().allFinite());
      break;
    case 4:
      if (const auto sensor = dataset::parse_sensor(bytes); sensor) fuzz::require(sensor->sensor.max_range_m >= 0);
      break;
    default:
      if (const auto unpacked = dataset::lzf_unpack(bytes, 4 * bytes.size()); unpacked)
        fuzz::require(unpacked->size() == 4 * bytes.size());
  }
  return 0;
}
