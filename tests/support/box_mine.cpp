#include "tests/support/box_mine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/descriptor/family.hpp"
#include "common/descriptor/wall_profile.hpp"

namespace headframe::test {
namespace {

constexpr double farthest_m = 60;

Keyframe make_keyframe(std::uint64_t sequence, const Pose& T_local_sensor, const Points& scan) {
  Keyframe keyframe;
  keyframe.sequence = sequence;
  keyframe.stamp_s = static_cast<double>(sequence);
  keyframe.T_local_sensor = T_local_sensor;
  keyframe.spaciousness_m = 5;
  keyframe.point_count = static_cast<std::uint32_t>(scan.size());
  const Pose T_level_sensor = levelled(T_local_sensor).inverse() * T_local_sensor;
  Points level;
  for (const auto& p : scan) level.push_back((T_level_sensor * p.cast<double>()).cast<float>());
  keyframe.walls = wall_profile(level);
  static const auto family = make_family(default_family_name).value();
  if (auto d = family->extract(level)) keyframe.descriptor = *d;
  return keyframe;
}

}  // namespace

Box BoxMine::drift(double x0, double y0, double x1, double y1, double width_m, double height_m) {
  const double h = width_m / 2;
  return {{std::min(x0, x1) - h, std::min(y0, y1) - h, 0}, {std::max(x0, x1) + h, std::max(y0, y1) + h, height_m}};
}

double BoxMine::range_m(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const {
  double t = 0;
  while (t < farthest_m) {
    const Eigen::Vector3d p = from + (t + 1e-6) * direction;
    double out = t;
    for (const Box& box : boxes_) {
      if ((p.array() < box.low.array()).any() || (p.array() > box.high.array()).any()) continue;
      double exit = farthest_m;
      for (int i = 0; i < 3; ++i) {
        if (direction[i] > 1e-12) exit = std::min(exit, (box.high[i] - from[i]) / direction[i]);
        if (direction[i] < -1e-12) exit = std::min(exit, (box.low[i] - from[i]) / direction[i]);
      }
      out = std::max(out, exit);
    }
    if (out <= t + 1e-9) break;  // no box goes on from here: this is the wall
    t = out;
  }
  return std::min(t, farthest_m);
}

Points BoxMine::scan(const Pose& T_mine_sensor, std::mt19937& rng, double noise_m, int beams, int columns) const {
  std::normal_distribution<double> noise(0, noise_m);
  Points points;
  for (int b = 0; b < beams; ++b)
    for (int c = 0; c < columns; ++c) {
      const double elevation = (-22.5 + 45.0 * (b + 0.5) / beams) * std::numbers::pi / 180;
      const double azimuth = 2 * std::numbers::pi * (c + 0.5) / columns;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      const double range = range_m(T_mine_sensor.translation(), T_mine_sensor.linear() * ray);
      if (range < farthest_m) points.push_back(((range + noise(rng)) * ray).cast<float>());
    }
  return points;
}

Drive drive(const BoxMine& mine, const std::vector<Eigen::Vector2d>& corners, double frame_yaw_rad, unsigned seed,
            double spacing_m) {
  std::mt19937 rng(seed);
  std::vector<Pose> poses;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i] - corners[i - 1];
    const double heading = std::atan2(leg.y(), leg.x());
    for (int k = 0; k * spacing_m < leg.norm(); ++k) {
      const Eigen::Vector2d p = corners[i - 1] + k * spacing_m * leg.normalized();
      poses.push_back(pose_from_yaw(heading, {p.x(), p.y(), 1.2}));
    }
  }
  Drive out;
  out.T_mine_local = pose_from_yaw(frame_yaw_rad, poses.front().translation());
  for (const Pose& T_mine_sensor : poses) {
    const Points scan = mine.scan(T_mine_sensor, rng);
    const Pose T_local_sensor = out.T_mine_local.inverse() * T_mine_sensor;
    out.keyframes.push_back(make_keyframe(out.keyframes.size() + 1, T_local_sensor, scan));
    out.clouds.push_back({{{Eigen::Vector3f::Zero(), scan}}});
  }
  return out;
}

}  // namespace headframe::test
