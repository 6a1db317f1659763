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

/// A value that wanders around 0 with the given sigma; steps that lie correlation_m apart have little in common.
class Wander {
 public:
  Wander(double sigma, double correlation_m, double step_m)
      : keep_(std::exp(-step_m / correlation_m)), renew_(sigma * std::sqrt(1 - keep_ * keep_)) {}
  double step(Rng& rng) { return value_ = keep_ * value_ + renew_ * rng.normal(); }

 private:
  double keep_;
  double renew_;
  double value_ = 0;
};

/// Where a sensor wished to stand `wish_m` left of the middle stands, 0.8 m from both walls; half-way where there is
/// less.
double side_within(double wish_m, double to_left_m, double to_right_m) {
  const double low_m = 0.8 - to_right_m, high_m = to_left_m - 0.8;
  return low_m < high_m ? std::clamp(wish_m, low_m, high_m) : 0.5 * (low_m + high_m);
}

/// The sensor over a place of the floor: below the roof, off the walls.
Eigen::Vector3d sensor_place(const Eigen::Vector3d& floor, const Eigen::Vector3d& left, double height_m, double side_m,
                             const RayCaster& caster) {
  Eigen::Vector3d p = floor;
  const double roof_m = 0.5 + room_m(caster, p + Eigen::Vector3d(0, 0, 0.5), Eigen::Vector3d::UnitZ());
  p.z() += std::min(height_m, std::max(0.3, roof_m - 0.7));
  return p + side_within(side_m, room_m(caster, p, left), room_m(caster, p, -left)) * left;
}

std::vector<Pose> true_poses(const Route& route, const DriveStyle& style, const RayCaster& caster, Rng rng) {
  const Route way = smoothed(route);
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(style.scan_spacing_m / route_step_m)));
  const double step_m = route_step_m * static_cast<double>(stride);
  Wander roll(style.tilt_sigma_rad, 2, step_m), pitch(style.tilt_sigma_rad, 2, step_m);
  Wander side(0.5, 12, step_m), heading(0.05, 6, step_m);
  const auto tilt_rad = [&](Wander& w) { return std::clamp(w.step(rng), -max_tilt_rad * 0.7, max_tilt_rad * 0.7); };
  std::vector<Pose> poses;
  for (std::size_t i = 0; i + 1 < way.size(); i += stride) {
    const Eigen::Vector3d along = way[std::min(i + 2, way.size() - 1)] - way[i < 2 ? 0 : i - 2];
    const double yaw = std::atan2(along.y(), along.x());
    const Eigen::Vector3d left(-std::sin(yaw), std::cos(yaw), 0);
    const double turn = heading.step(rng), nod = tilt_rad(pitch), lean = tilt_rad(roll);
    Pose T = Pose::Identity();
    T.translation() = sensor_place(way[i], left, style.sensor_height_m, side.step(rng), caster);
    T.rotate(Eigen::AngleAxisd(yaw + turn, Eigen::Vector3d::UnitZ()));
    T.rotate(Eigen::AngleAxisd(nod, Eigen::Vector3d::UnitY()));
    T.rotate(Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitX()));
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
