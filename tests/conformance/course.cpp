#include "tests/conformance/course.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <stdexcept>

#include "client/keyframe/keyframe_selector.hpp"
#include "common/dataset/scan_file.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::conformance {
namespace {

constexpr int scan_count = 150;
constexpr double step_m = 1.5;
constexpr double rate_hz = 2;
constexpr int beams = 24, columns = 180;

test::BoxMine tunnel() {
  std::vector<test::Box> boxes{{{-4, -1.3, 0}, {scan_count * step_m + 4, 1.7, 2.6}}};
  for (double x = 5; x < scan_count * step_m; x += 11 + std::fmod(x, 4))
    boxes.push_back({{x, 1.0, 0}, {x + 2.5, 4.5, 2.2}});  // niches, all on the left
  return test::BoxMine(boxes);
}

Pose sensor_at(int i) {
  const double s = i * 0.37;
  Pose T = pose_from_yaw(0.25 * std::sin(0.6 * s), {i * step_m, 0.3 * std::sin(s), 1.1 + 0.1 * std::cos(0.8 * s)});
  T.rotate(Eigen::AngleAxisd(0.12 + 0.05 * std::sin(1.3 * s), Eigen::Vector3d::UnitY()));
  T.rotate(Eigen::AngleAxisd(-0.09 + 0.04 * std::cos(0.9 * s), Eigen::Vector3d::UnitX()));
  return T;
}

std::string name_of(std::size_t i) {
  char name[32];
  std::snprintf(name, sizeof name, "%06zu.bin", i);
  return name;
}

}  // namespace

Course::Course() {
  const auto mine = tunnel();
  std::mt19937 rng(5);
  const Pose T_local_mine = pose_from_yaw(-0.9, {20, -7, 0.5});
  KeyframeSelector selector;
  for (int i = 0; i < scan_count; ++i) {
    const Pose T_mine_sensor = sensor_at(i);
    Scan scan{1000 + i / rate_hz, orthonormalised(T_local_mine * T_mine_sensor),
              mine.scan(T_mine_sensor, rng, 0.01, beams, columns)};
    const auto decision = selector.add(scan.T_local_sensor, mean_range_m(scan.points_sensor));
    scan.spaciousness_m = decision.spaciousness_m;
    keyframes_ += decision.keyframe ? 1 : 0;
    scans_.push_back(std::move(scan));
  }
}

const Course::Scan* Course::at(double stamp_s) const {
  const double i = std::round((stamp_s - scans_.front().stamp_s) * rate_hz);
  if (!(i >= 0 && i < static_cast<double>(scans_.size()))) return nullptr;
  const Scan& scan = scans_[static_cast<std::size_t>(i)];
  return std::abs(scan.stamp_s - stamp_s) < 1e-6 ? &scan : nullptr;
}

void Course::write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder / "scans");
  std::ofstream(folder / "sensor.json") << R"({"model": ")" << sensor_.model << R"(", "beams": )" << sensor_.beams
                                        << R"(, "fov_up_deg": 22.5, "fov_down_deg": 22.5, "max_range_m": 60})";
  std::ofstream poses(folder / "poses.txt");
  poses.precision(17);
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const Eigen::Quaterniond q(scans_[i].T_local_sensor.linear());
    poses << scans_[i].stamp_s << ' ' << scans_[i].T_local_sensor.translation().transpose() << ' '
          << q.coeffs().transpose() << '\n';
    const std::vector<float> intensity(scans_[i].points_sensor.size(), 0.5F);
    if (const auto written = write_kitti(folder / "scans" / name_of(i), scans_[i].points_sensor, intensity); !written)
      throw std::runtime_error(written.error().message);
  }
  if (!poses.flush()) throw std::runtime_error((folder / "poses.txt").string() + " can not be written");
}

}  // namespace headframe::conformance
