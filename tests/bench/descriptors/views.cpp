#include "tests/bench/descriptors/views.hpp"

#include <numbers>
#include <stdexcept>

#include "common/dataset/session_folder.hpp"
#include "common/descriptor/level.hpp"
#include "tests/bench/descriptors/retrieval.hpp"
#include "tests/mine/overlap.hpp"
#include "tests/mine/parallel.hpp"
#include "tests/support/truth.hpp"

namespace headframe::bench {
namespace {

constexpr float min_range_m = 0.3F;
constexpr double apart_m = 1.8;  // recordings have a scan about every 1 or 2 m: 2 m apart, but for their jitter
constexpr double tilt_of_scans_rad = 10 * std::numbers::pi / 180;
constexpr double seen_voxel_m = 1, seen_reach_m = 20;

View view_of(const Points& points_sensor, const Pose& T_local_sensor, const Pose& T_world_sensor) {
  return {level(T_local_sensor, finite_points(points_sensor, min_range_m)),
          T_world_sensor * level_from_sensor(T_local_sensor).inverse()};
}

Points rotated(const Points& points, const Eigen::Matrix3f& R) {
  Points out;
  out.reserve(points.size());
  for (const auto& p : points) out.emplace_back(R * p);
  return out;
}

std::vector<mine::SeenVoxels> seen_of(const Drive& drive) {
  std::vector<mine::SeenVoxels> seen(drive.size(), mine::SeenVoxels(seen_voxel_m));
  mine::for_each_index(
      drive.size(), [&](std::size_t i) { seen[i].add(drive[i].points_level, drive[i].T_world_level, seen_reach_m); });
  return seen;
}

std::vector<double> headings_rad(const Drive& drive) {
  std::vector<double> out;
  out.reserve(drive.size());
  for (const View& view : drive) out.push_back(yaw_rad(view.T_world_level));
  return out;
}

}  // namespace

Drive drive_of(const mine::Recording& recording) {
  Drive drive(recording.scans.size());
  mine::for_each_index(drive.size(), [&](std::size_t i) {
    drive[i] = view_of(recording.scans[i].points, recording.drive.T_local_sensor[i], recording.drive.T_world_sensor[i]);
  });
  return drive;
}

Drive read_drive(const std::filesystem::path& recording, const std::string& robot) {
  const auto folder = SessionFolder::open(recording / robot);
  if (!folder) throw std::runtime_error(folder.error().message);
  const test::TruePath path = test::read_true_path(recording, robot);
  if (path.T_world_sensor.size() != folder->size())
    throw std::runtime_error((recording / robot).string() + ": " + std::to_string(folder->size()) + " scans, but " +
                             std::to_string(path.T_world_sensor.size()) + " true poses; the recording is incomplete");
  Drive drive;
  Eigen::Vector3d last = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < folder->size(); ++i) {
    const Pose& T_local_sensor = folder->T_local_sensor(i);
    if ((T_local_sensor.translation() - last).norm() < apart_m) continue;
    const auto scan = folder->load(i);
    if (!scan) throw std::runtime_error(scan.error().message);
    drive.push_back(view_of(scan->points, T_local_sensor, path.T_world_sensor[i]));
    last = T_local_sensor.translation();
  }
  return drive;
}

Drive tilted(const Drive& drive, std::uint64_t seed) {
  Drive out = drive;
  mine::Rng rng(seed);
  for (View& view : out) {
    const auto towards = static_cast<float>(rng.uniform(0, 2 * std::numbers::pi));
    const Eigen::Vector3f axis(std::cos(towards), std::sin(towards), 0);
    view.points_level =
        rotated(view.points_level, Eigen::AngleAxisf(static_cast<float>(tilt_of_scans_rad), axis).toRotationMatrix());
  }
  return out;
}

Points turned(const Points& points_level, double yaw_rad) {
  return rotated(points_level,
                 Eigen::AngleAxisf(static_cast<float>(-yaw_rad), Eigen::Vector3f::UnitZ()).toRotationMatrix());
}

Truth truth_of(const Drive& a, const Drive& b) {
  const auto seen_a = seen_of(a), seen_b = seen_of(b);
  Truth truth{std::vector<std::vector<std::size_t>>(b.size()), headings_rad(a), headings_rad(b)};
  for (std::size_t j = 0; j < b.size(); ++j)
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double distance_m = (a[i].T_world_level.translation() - b[j].T_world_level.translation()).norm();
      if (distance_m <= right_m && is_right(distance_m, overlap_pct(seen_a[i], seen_b[j]))) truth.right[j].push_back(i);
    }
  return truth;
}

}  // namespace headframe::bench
