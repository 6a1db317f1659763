#include "client/keyframe/keyframe_selector.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

constexpr double cell_m = 10.0;  // the largest threshold: all that is nearer lies in the 27 cubes around a point
constexpr double reach_m = 1e9;  // keeps the cube numbers within an integer
constexpr double path_step_m = 1.0;

// 21 bits for each coordinate. Cubes that are 2^21 apart share a key, which is harmless, as distances are checked.
std::uint64_t cell_key(const Eigen::Vector3d& p, int dx, int dy, int dz) {
  const int step[3] = {dx, dy, dz};
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const auto c = static_cast<std::int64_t>(std::floor(p[i] / cell_m)) + step[i];
    key = key << 21 | (static_cast<std::uint64_t>(c) & 0x1fffff);
  }
  return key;
}

double angle_between_rad(const Pose& a, const Pose& b) { return rotation_angle_rad(a.inverse() * b); }

}  // namespace

double distance_threshold_m(float spaciousness_m) {
  if (spaciousness_m > 10) return 10;
  if (spaciousness_m > 6) return 6;
  if (spaciousness_m > 3) return 3;
  return spaciousness_m;
}

float mean_range_m(const Points& points_sensor) {
  double sum_m = 0;
  for (const auto& p : points_sensor) sum_m += p.norm();
  return points_sensor.empty() ? 0.0F : static_cast<float>(sum_m / static_cast<double>(points_sensor.size()));
}

KeyframeSelector::KeyframeSelector(KeyframeConfig config) : config_(config) {}

KeyframeSelector::Decision KeyframeSelector::add(const Pose& T_local_sensor, float mean_range_m) {
  smooth(mean_range_m);
  const Eigen::Vector3d p_local = T_local_sensor.translation();
  const bool usable = T_local_sensor.matrix().allFinite() && p_local.cwiseAbs().maxCoeff() < reach_m;
  if (usable) drive_to(p_local);
  if (!usable || !is_keyframe(T_local_sensor)) return {false, spaciousness_m_};
  remember(T_local_sensor);
  return {true, spaciousness_m_};
}

void KeyframeSelector::restore(const Pose& T_local_sensor, float spaciousness_m) {
  spaciousness_m_ = spaciousness_m;
  drive_to(T_local_sensor.translation());
  remember(T_local_sensor);
}

void KeyframeSelector::move(std::span<const KeyframePose> moved, float spaciousness_m) {
  for (const KeyframePose& pose : moved) {
    const std::size_t i = pose.sequence - 1;
    Pose& T_local_sensor = keyframes_.at(i).T_local_sensor;
    const std::uint64_t was = cell_key(T_local_sensor.translation(), 0, 0, 0),
                        now = cell_key(pose.T_local_sensor.translation(), 0, 0, 0);
    T_local_sensor = pose.T_local_sensor;
    if (was == now) continue;
    const auto left = cells_.find(was);
    std::erase(left->second, i);
    if (left->second.empty()) cells_.erase(left);
    cells_[now].push_back(i);
  }
  spaciousness_m_ = spaciousness_m;
  path_m_ = 0;
  path_end_local_.reset();
  for (Chosen& keyframe : keyframes_) {
    drive_to(keyframe.T_local_sensor.translation());
    keyframe.path_m = path_m_;
  }
}

void KeyframeSelector::drive_to(const Eigen::Vector3d& p_local) {
  const double step_m = path_end_local_ ? (p_local - *path_end_local_).norm() : path_step_m;
  if (step_m < path_step_m) return;
  if (path_end_local_) path_m_ += step_m;
  path_end_local_ = p_local;
}

void KeyframeSelector::remember(const Pose& T_local_sensor) {
  cells_[cell_key(T_local_sensor.translation(), 0, 0, 0)].push_back(keyframes_.size());
  keyframes_.push_back({T_local_sensor, path_m_});
}

// s_k = 0.9 s_{k-1} + 0.1 S_k; the first scan starts the filter, so s_0 = S_0.
void KeyframeSelector::smooth(float mean_range_m) {
  if (!std::isfinite(mean_range_m) || mean_range_m <= 0) return;
  spaciousness_m_ =
      spaciousness_m_ > 0 ? config_.smoothing * spaciousness_m_ + (1 - config_.smoothing) * mean_range_m : mean_range_m;
}

bool KeyframeSelector::is_keyframe(const Pose& T_local_sensor) const {
  if (keyframes_.empty()) return true;
  const double threshold_m = std::max(distance_threshold_m(spaciousness_m_), config_.least_threshold_m);
  const Nearby near = nearby(T_local_sensor, threshold_m);
  if (!near.any) return true;
  const Chosen& last = keyframes_.back();
  if (!near.lately && path_m_ - last.path_m >= config_.known_spacing_m - step_rounding) return true;
  return !near.same_way &&
         angle_between_rad(last.T_local_sensor, T_local_sensor) >= config_.rotation_rad - step_rounding;
}

KeyframeSelector::Nearby KeyframeSelector::nearby(const Pose& T_local_sensor, double threshold_m) const {
  Nearby found;
  const Eigen::Vector3d p_local = T_local_sensor.translation();
  for (int i = 0; i < 27; ++i) {
    const auto cell = cells_.find(cell_key(p_local, i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
    if (cell == cells_.end()) continue;
    for (const std::size_t k : cell->second) {
      const auto& [T_local_keyframe, path_m] = keyframes_[k];
      if ((T_local_keyframe.translation() - p_local).norm() >= threshold_m - step_rounding) continue;
      found.any = true;
      if (path_m_ - path_m < config_.known_after_m - step_rounding) found.lately = true;
      if (angle_between_rad(T_local_keyframe, T_local_sensor) < config_.rotation_rad - step_rounding)
        found.same_way = true;
    }
  }
  return found;
}

}  // namespace headframe
