#include "common/dataset/scan_file.hpp"

#include <algorithm>
#include <fstream>

#include "common/dataset/scan_formats.hpp"
#include "common/dataset/text.hpp"

namespace headframe {
namespace {

// Limits beyond any lidar's range, so that one damaged value does not dominate the mean range of a scan.
constexpr float nearest_m = 0.01F;
constexpr float farthest_m = 1e4F;

using Parser = Result<dataset::ScanTable> (*)(std::string_view);

Parser parser_of(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".bin") return dataset::parse_kitti;
  if (ending == ".pcd") return dataset::parse_pcd;
  if (ending == ".ply") return dataset::parse_ply;
  return nullptr;
}

}  // namespace

bool is_scan_file(const std::filesystem::path& path) { return parser_of(path) != nullptr; }

Result<Scan> load_scan(const std::filesystem::path& path) {
  const Parser parse = parser_of(path);
  if (parse == nullptr) return failure(ErrorCode::invalid_argument, path.string() + ": not a .bin, .pcd or .ply scan");
  const auto bytes = dataset::read_file(path, dataset::most_scan_bytes);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto table = parse(*bytes);
  if (!table) return failure(table.error().code, path.string() + ": " + table.error().message);
  Scan scan;
  scan.points.reserve(table->points.size());
  scan.intensity.reserve(table->intensity.size());
  for (std::size_t i = 0; i < table->points.size(); ++i) {
    const Eigen::Vector3f& p = table->points[i];
    if (!p.allFinite() || p.squaredNorm() < nearest_m * nearest_m || p.cwiseAbs().maxCoeff() > farthest_m) continue;
    scan.points.push_back(p);
    if (!table->intensity.empty()) scan.intensity.push_back(table->intensity[i]);
  }
  scan.dropped = table->points.size() - scan.points.size();
  return scan;
}

Result<void> write_kitti(const std::filesystem::path& path, const Points& points, const std::vector<float>& intensity) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    const float row[4] = {p.x(), p.y(), p.z(), i < intensity.size() ? intensity[i] : 0};
    file.write(reinterpret_cast<const char*>(row), sizeof row);
  }
  file.close();
  if (!file) return failure(ErrorCode::unavailable, path.string() + ": cannot be written");
  return {};
}

}  // namespace headframe
