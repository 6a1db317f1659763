#include "tests/mine/drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headframe::mine {
namespace {

constexpr double max_tilt_rad = 5.0 * std::numbers::pi / 180.0;
constexpr int half_window = 4;  // route points: corners are cut by a mean over 4 m

Route smoothed(const Route& route) {
  Route out(route.size());
  const int n = static_cast<int>(route.size());
  for (int i = 0; i < n; ++i) {
    const int reach = std::min({half_window, i, n - 1 - i});
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = i - reach; k <= i + reach; ++k) sum += route[static_cast<std::size_t>(k)];
    out[static_cast<std::size_t>(i)] = sum / (2 * reach + 1);
  }
  return out;
}

double room_m(const RayCaster& caster, const Eigen::Vector3d& p, const Eigen::Vector3d& direction) {
  const auto hit = caster.cast(p.cast<float>(), direction.cast<float>(), 20.0F);
  return hit ? hit->range_m : 20.0;
}

/// A value that wanders around 0 with the given sigma, correlated over some 5 steps.
class Wander {
 public:
  explicit Wander(double sigma) : sigma_(sigma) {}
  double step(Rng& rng) { return value_ = 0.8 * value_ + 0.6 * sigma_ * rng.normal(); }

 private:
  double sigma_;
  double value_ = 0;
};

std::vector<Pose> true_poses(const Route& route, const DriveStyle& style, const RayCaster& caster, Rng rng) {
  const Route way = smoothed(route);
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(style.scan_spacing_m / route_step_m)));
  Wander roll(style.tilt_sigma_rad), pitch(style.tilt_sigma_rad), side(0.5), heading(0.05);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i + 1 < way.size(); i += stride) {
    const Eigen::Vector3d along = way[std::min(i + 2, way.size() - 1)] - way[i < 2 ? 0 : i - 2];
    const double yaw = std::atan2(along.y(), along.x());
    const Eigen::Vector3d left(-std::sin(yaw), std::cos(yaw), 0);
    Eigen::Vector3d p = way[i];
    const double above_m = room_m(caster, p + Eigen::Vector3d(0, 0, 0.5), Eigen::Vector3d::UnitZ()) + 0.5;
    p.z() += std::min(style.sensor_height_m, std::max(0.3, above_m - 0.7));
    const double to_left_m = room_m(caster, p, left), to_right_m = room_m(caster, p, -left);
    const double free_m = std::max(0.0, 0.5 * (to_left_m + to_right_m) - 1.3);
    p += left * std::clamp(side.step(rng), std::max(-free_m, 0.8 - to_right_m),
                           std::max(std::min(free_m, to_left_m - 0.8), std::max(-free_m, 0.8 - to_right_m)));
    Pose T = Pose::Identity();
    T.translation() = p;
    const auto tilt = [&](Wander& w) { return std::clamp(w.step(rng), -max_tilt_rad * 0.7, max_tilt_rad * 0.7); };
    T.linear() = (Eigen::AngleAxisd(yaw + heading.step(rng), Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(tilt(pitch), Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(tilt(roll), Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    poses.push_back(T);
  }
  return poses;
}

/// Odometry: a scale error of the whole drive, and random walks of heading and place.
std::vector<Pose> believed_poses(const std::vector<Pose>& T_world, const Pose& T_world_local, double drift, Rng rng) {
  const double scale = 1.0 + drift * 0.002 * rng.normal();
  std::vector<Pose> T_local;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double yaw_error = 0;
  const Eigen::Matrix3d R_local_world = T_world_local.linear().transpose();
  for (std::size_t i = 0; i < T_world.size(); ++i) {
    if (i > 0) {
      const Eigen::Vector3d step = R_local_world * (T_world[i].translation() - T_world[i - 1].translation());
      const double root_m = std::sqrt(step.norm());
      yaw_error += drift * 5e-4 * root_m * rng.normal();
      const Eigen::Vector3d jitter(0.012 * rng.normal(), 0.012 * rng.normal(), 0.008 * rng.normal());
      place += Eigen::AngleAxisd(yaw_error, Eigen::Vector3d::UnitZ()) * (scale * step) + drift * root_m * jitter;
    }
    Pose T = Pose::Identity();
    T.translation() = place;
    T.linear() = Eigen::AngleAxisd(yaw_error, Eigen::Vector3d::UnitZ()) * R_local_world * T_world[i].linear();
    T_local.push_back(T);
  }
  return T_local;
}

}  // namespace

Drive drive_along(const Route& route, const DriveStyle& style, const RayCaster& caster, Rng rng) {
  Drive drive;
  drive.T_world_sensor = true_poses(route, style, caster, rng.fork(1));
  if (drive.T_world_sensor.empty()) return drive;
  drive.T_world_local = pose_from_yaw(style.frame_yaw_rad, drive.T_world_sensor.front().translation());
  drive.T_local_sensor = believed_poses(drive.T_world_sensor, drive.T_world_local, style.drift, rng.fork(2));
  return drive;
}

}  // namespace headframe::mine
