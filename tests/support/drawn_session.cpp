#include "tests/support/drawn_session.hpp"

#include <cstdio>
#include <fstream>

#include "common/dataset/scan_file.hpp"

namespace headframe::test {

void write_session(const std::filesystem::path& folder, const Drive& drive, std::int64_t begun_s) {
  std::filesystem::create_directories(folder / "scans");
  std::ofstream(folder / "sensor.json")
      << R"({"model": "drawn-32", "beams": 32, "fov_up_deg": 22.5, "fov_down_deg": 22.5, "max_range_m": 60})";
  std::ofstream poses(folder / "poses.txt");
  poses.precision(9);
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
    const Pose& T = drive.keyframes[i].T_local_sensor;
    const Eigen::Quaterniond q(T.linear());
    poses << begun_s + static_cast<std::int64_t>(i) << ' ' << T.translation().transpose() << ' '
          << q.coeffs().transpose() << '\n';
    char name[32];
    std::snprintf(name, sizeof name, "%06zu.bin", i);
    const Points& points = drive.clouds[i].sweeps.front().points;
    const std::vector<float> intensity(points.size(), 0.5F);
    if (const auto written = write_kitti(folder / "scans" / name, points, intensity); !written)
      throw std::runtime_error(written.error().message);
  }
}

const BoxMine& branches_mine() {
  static const BoxMine mine(
      {BoxMine::drift(0, 0, 90, 0), BoxMine::drift(30, 0, 30, 40), BoxMine::drift(60, -25, 60, 0, 6)});
  return mine;
}

Drive drive_a_to_c(double spacing_m) { return drive(branches_mine(), {{2, 0}, {30, 0}, {30, 38}}, 0, 1, spacing_m); }
Drive drive_b_to_a(double spacing_m) { return drive(branches_mine(), {{88, 0}, {4, 0}}, 2.3, 2, spacing_m); }
Drive drive_a_to_b(double spacing_m) { return drive(branches_mine(), {{4, 0}, {88, 0}}, 0.7, 4, spacing_m); }
Drive drive_d_to_b(double spacing_m) {
  return drive(branches_mine(), {{60, -23}, {60, 0}, {88, 0}}, -1.1, 3, spacing_m);
}

Drive drive_b_to_c_driven_on(double spacing_m) {
  static const BoxMine later(
      {BoxMine::drift(0, 0, 90, 0), BoxMine::drift(30, 0, 30, 52), BoxMine::drift(60, -25, 60, 0, 6)});
  return drive(later, {{88, 0}, {30, 0}, {30, 50}}, 0.8, 4, spacing_m);
}

const BoxMine& other_mine() {
  static const BoxMine mine(
      {BoxMine::drift(0, 0, 80, 0, 5), BoxMine::drift(20, -35, 20, 0), BoxMine::drift(55, 0, 55, 30, 6)});
  return mine;
}

Drive carried(Drive drive, const Drive& after, const Eigen::Vector3d& by_m, double rest_s) {
  const Pose T_first = drive.keyframes.back().T_local_sensor;
  const Pose T = Eigen::Translation3d(T_first.translation() + by_m) * after.keyframes.front().T_local_sensor.inverse();
  const double shift_s = drive.keyframes.back().stamp_s + rest_s - after.keyframes.front().stamp_s;
  for (std::size_t i = 0; i < after.keyframes.size(); ++i) {
    Keyframe keyframe = after.keyframes[i];
    keyframe.sequence = drive.keyframes.size() + 1;
    keyframe.stamp_s += shift_s;
    keyframe.T_local_sensor = T * keyframe.T_local_sensor;
    drive.keyframes.push_back(keyframe);
    drive.clouds.push_back(after.clouds[i]);
  }
  return drive;
}

}  // namespace headframe::test
