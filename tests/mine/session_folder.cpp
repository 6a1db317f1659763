#include "tests/mine/session_folder.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

namespace headframe::mine {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double rad_to_deg = 180 / std::numbers::pi;
constexpr double voxel_m = 0.5;
constexpr double near_m = 20;
constexpr double all_ranges_m = 1e9;

Result<void> write_file(const fs::path& path, const void* data, std::size_t bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  out.close();
  if (!out) return failure(ErrorCode::unavailable, "cannot write " + path.string() + "; is there room, and may we?");
  return {};
}

Result<void> write_text(const fs::path& path, const std::string& text) {
  return write_file(path, text.data(), text.size());
}

Json matrix(const Pose& T) {
  Json numbers = Json::array();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) numbers.push_back(T.matrix()(row, column));
  return numbers;
}

std::string sensor_json(const LidarModel& lidar) {
  return Json{{"model", lidar.name},
              {"beams", lidar.beams},
              {"columns", lidar.columns},
              {"fov_up_deg", lidar.fov_up_deg},
              {"fov_down_deg", lidar.fov_down_deg},
              {"min_range_m", lidar.min_range_m},
              {"max_range_m", lidar.max_range_m},
              {"range_sigma_m", lidar.range_sigma_m}}
             .dump() +
         "\n";
}

Result<void> write_session(const fs::path& dir, const Recording& recording) {
  std::error_code error;
  fs::remove_all(dir / "scans", error);
  fs::create_directories(dir / "scans", error);
  if (error) return failure(ErrorCode::unavailable, "cannot make " + (dir / "scans").string() + ": " + error.message());
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const Scan& scan = recording.scans[i];
    std::vector<float> values;
    values.reserve(4 * scan.points.size());
    for (std::size_t k = 0; k < scan.points.size(); ++k) {
      const auto& p = scan.points[k];
      values.insert(values.end(), {p.x(), p.y(), p.z(), scan.intensity[k]});
    }
    char name[32];
    std::snprintf(name, sizeof name, "%06zu.bin", i);
    if (auto ok = write_file(dir / "scans" / name, values.data(), values.size() * sizeof(float)); !ok) return ok;
  }
  if (auto ok = write_text(dir / "sensor.json", sensor_json(recording.robot.lidar)); !ok) return ok;
  return write_text(dir / "poses.txt", tum_text(recording.drive.T_local_sensor, recording.robot.style.scan_spacing_m));
}

struct Seen {
  SeenVoxels all{voxel_m};
  SeenVoxels near{voxel_m};
};

Json robot_truth(const Recording& recording, const Seen& voxels) {
  const Drive& drive = recording.drive;
  const Pose T_true_believed =
      (drive.T_world_local * drive.T_local_sensor.back()) * drive.T_world_sensor.back().inverse();
  const Pose T_end = drive.T_world_sensor.back().inverse() * drive.T_world_local * drive.T_local_sensor.back();
  return {{"world_from_local", matrix(drive.T_world_local)},
          {"frame_yaw_deg", yaw_rad(drive.T_world_local) * rad_to_deg},
          {"trajectory_length_m", length_m(recording.robot.route)},
          {"scans", recording.scans.size()},
          {"sensor", recording.robot.lidar.name},
          {"dust", recording.robot.dust},
          {"occupied_voxels", voxels.all.size()},
          {"end_drift_m", T_end.translation().norm()},
          {"end_drift_yaw_deg", std::abs(yaw_rad(T_true_believed)) * rad_to_deg}};
}

double nearest_poses_m(const Recording& a, const Recording& b) {
  double best = all_ranges_m;
  for (const Pose& p : a.drive.T_world_sensor)
    for (const Pose& q : b.drive.T_world_sensor) best = std::min(best, (p.translation() - q.translation()).norm());
  return best;
}

Json pair_truth(const Recording& a, const Recording& b, const Seen& voxels_a, const Seen& voxels_b) {
  const Pose T_a_b = a.drive.T_world_local.inverse() * b.drive.T_world_local;
  return {{"a", a.robot.name},
          {"b", b.robot.name},
          {"overlap_pct", overlap_pct(voxels_a.all, voxels_b.all)},
          {"overlap_20m_pct", overlap_pct(voxels_a.near, voxels_b.near)},
          {"path_within_3m_pct", 100 * shared_part(b.robot.route, a.robot.route, 3)},
          {"nearest_poses_m", nearest_poses_m(a, b)},
          {"relative_yaw_deg", yaw_rad(T_a_b) * rad_to_deg},
          {"a_from_b", matrix(T_a_b)}};
}

}  // namespace

std::string tum_text(const std::vector<Pose>& poses, double scan_spacing_m) {
  std::string text;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Quaterniond q(poses[i].linear());
    const Eigen::Vector3d p = poses[i].translation();
    char line[256];
    std::snprintf(line, sizeof line, "%.3f %.6f %.6f %.6f %.8f %.8f %.8f %.8f\n",
                  scan_spacing_m * static_cast<double>(i), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
    text += line;
  }
  return text;
}

Result<void> write_recordings(const fs::path& dir, const std::string& title, const std::string& world,
                              const std::vector<Recording>& recordings) {
  std::error_code error;
  fs::create_directories(dir / "truth", error);
  if (error) return failure(ErrorCode::unavailable, "cannot make " + (dir / "truth").string() + ": " + error.message());
  std::vector<Seen> voxels;
  Json robots = Json::object(), pairs = Json::array();
  for (const Recording& recording : recordings) {
    if (auto ok = write_session(dir / recording.robot.name, recording); !ok) return ok;
    const auto truth = tum_text(recording.drive.T_world_sensor, recording.robot.style.scan_spacing_m);
    if (auto ok = write_text(dir / "truth" / (recording.robot.name + ".txt"), truth); !ok) return ok;
    voxels.push_back({seen(recording, voxel_m, all_ranges_m), seen(recording, voxel_m, near_m)});
    robots[recording.robot.name] = robot_truth(recording, voxels.back());
  }
  for (std::size_t i = 0; i < recordings.size(); ++i)
    for (std::size_t k = i + 1; k < recordings.size(); ++k)
      pairs.push_back(pair_truth(recordings[i], recordings[k], voxels[i], voxels[k]));
  const double spacing_m = recordings.empty() ? 0 : recordings.front().robot.style.scan_spacing_m;
  const Json truth{
      {"scenario", title}, {"world", world}, {"scan_spacing_m", spacing_m}, {"robots", robots}, {"pairs", pairs}};
  return write_text(dir / "truth.json", truth.dump(2) + "\n");
}

}  // namespace headframe::mine
