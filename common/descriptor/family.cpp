#include "common/descriptor/family.hpp"

#include "common/descriptor/lidar_iris.hpp"
#include "common/descriptor/network_family.hpp"
#include "common/descriptor/scan_context.hpp"

namespace headframe {

Result<void> enough_points(const Points& points) {
  constexpr std::size_t fewest = 50;
  if (points.size() >= fewest) return {};
  return failure(ErrorCode::bad_input, "scan of " + std::to_string(points.size()) + " usable points, at least " +
                                           std::to_string(fewest) + " are needed for a descriptor");
}

Result<std::unique_ptr<DescriptorFamily>> make_family(std::string_view name) {
  if (name == "scan_context") return std::make_unique<ScanContext>();
  if (name == "lidar_iris") return std::make_unique<LidarIris>();
  if (name == "learned") return make_learned();
  if (name.starts_with("onnx:")) return make_onnx_family(name.substr(5));
  return failure(ErrorCode::not_found, "no descriptor family '" + std::string(name) +
                                           "'; there are: learned, scan_context, lidar_iris, onnx:FILE");
}

}  // namespace headframe
