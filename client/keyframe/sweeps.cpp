#include "client/keyframe/sweeps.hpp"

#include <utility>

#include "client/keyframe/keyframe_selector.hpp"

namespace headframe {
namespace {

Sweep moved(Returns scan, const Eigen::Isometry3f& T_keyframe_sensor) {
  Sweep sweep;
  sweep.intensity = std::move(scan.intensity);
  sweep.origin = T_keyframe_sensor.translation();
  sweep.points.reserve(scan.points.size());
  for (const auto& p : scan.points) sweep.points.emplace_back(T_keyframe_sensor * p);
  return sweep;
}

}  // namespace

SweepCollector::SweepCollector(SweepConfig config) : config_(config) {}

void SweepCollector::add(const Pose& T_local_sensor, const Points& points_sensor, const Intensities& intensity) {
  if (config_.most == 0) return;
  if (T_local_last_) {
    const Pose T_last_sensor = T_local_last_->inverse() * T_local_sensor;
    if (T_last_sensor.translation().norm() < config_.distance_m - step_rounding &&
        rotation_angle_rad(T_last_sensor) < config_.rotation_rad - step_rounding)
      return;
  }
  if (kept_.size() == config_.most) kept_.pop_front();
  kept_.push_back({T_local_sensor, voxel_grid(points_sensor, intensity, config_.leaf_m)});
  T_local_last_ = T_local_sensor;
}

KeyframeCloud SweepCollector::take(const Pose& T_local_keyframe, const Points& own_scan, const Intensities& intensity) {
  const Pose T_keyframe_local = T_local_keyframe.inverse();
  KeyframeCloud cloud;
  for (Kept& kept : kept_) {
    const Pose T_keyframe_sensor = T_keyframe_local * kept.T_local_sensor;
    if (T_keyframe_sensor.translation().norm() < config_.clear_of_keyframe_m - step_rounding) continue;
    cloud.sweeps.push_back(moved(std::move(kept.scan), T_keyframe_sensor.cast<float>()));
  }
  Returns own = voxel_grid(own_scan, intensity, config_.leaf_m);
  cloud.sweeps.push_back({Eigen::Vector3f::Zero(), std::move(own.points), std::move(own.intensity)});
  kept_.clear();
  T_local_last_ = T_local_keyframe;
  return cloud;
}

}  // namespace headframe
