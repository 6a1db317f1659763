#include "client/keyframe/corrected_keyframes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace headframe {
namespace {

/// The pose at this share of the way from one to the other: translation and rotation interpolated separately.
Pose between(const Pose& T_a, const Pose& T_b, double share) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::Quaterniond(T_a.rotation()).slerp(share, Eigen::Quaterniond(T_b.rotation())).toRotationMatrix();
  T.translation() = (1 - share) * T_a.translation() + share * T_b.translation();
  return T;
}

struct Change {
  double m = 0, rad = 0;
};

Change change(const Pose& T_from, const Pose& T_to) {
  return {(T_to.translation() - T_from.translation()).norm(), rotation_angle_rad(T_from.inverse() * T_to)};
}

Result<void> check(std::span<const TrajectoryPose> trajectory) {
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const TrajectoryPose& pose = trajectory[i];
    if (!std::isfinite(pose.stamp_s) || !pose.T_local_sensor.matrix().allFinite())
      return failure(ErrorCode::invalid_argument, "a stamp or pose of the trajectory is not finite");
    if (i > 0 && pose.stamp_s <= trajectory[i - 1].stamp_s)
      return failure(ErrorCode::invalid_argument,
                     "pose " + std::to_string(i + 1) + " of the trajectory has no later stamp than the one before");
  }
  return {};
}

/// The trajectory's pose at this time; nullopt if it has none near enough.
std::optional<Pose> pose_at(std::span<const TrajectoryPose> trajectory, double stamp_s, const CorrectionRules& rules) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_s,
                                      [](const TrajectoryPose& pose, double s) { return pose.stamp_s < s; });
  const bool has_after = after != trajectory.end(), has_before = after != trajectory.begin();
  const double to_after_s = has_after ? after->stamp_s - stamp_s : HUGE_VAL;
  const double to_before_s = has_before ? stamp_s - std::prev(after)->stamp_s : HUGE_VAL;
  if (std::min(to_before_s, to_after_s) <= rules.same_stamp_s)
    return (to_before_s < to_after_s ? *std::prev(after) : *after).T_local_sensor;
  if (!has_before || !has_after) return std::nullopt;
  const Pose &T_before = std::prev(after)->T_local_sensor, &T_after = after->T_local_sensor;
  const Change gap = change(T_before, T_after);
  const bool near = gap.m <= rules.most_gap_m && gap.rad <= rules.most_gap_rad;
  if (to_before_s + to_after_s > rules.most_gap_s && !near) return std::nullopt;
  return between(T_before, T_after, to_before_s / (to_before_s + to_after_s));
}

/// A keyframe whose pose is in the trajectory.
struct Match {
  std::size_t keyframe = 0;
  Pose T_now_was = Pose::Identity();  // in the local frame
};

}  // namespace

Result<CorrectedKeyframes> corrected_keyframes(std::span<const KnownKeyframe> keyframes,
                                               std::span<const TrajectoryPose> trajectory,
                                               const CorrectionRules& rules) {
  if (auto sound = check(trajectory); !sound) return tl::unexpected(sound.error());
  std::vector<Match> matches;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    if (const auto T = pose_at(trajectory, keyframes[i].stamp_s, rules))
      matches.push_back({i, *T * keyframes[i].T_local_sensor.inverse()});
  CorrectedKeyframes out{{}, matches.size()};
  if (matches.empty()) return out;
  std::size_t next = 0;  // the first match at or behind the keyframe
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    while (next < matches.size() && matches[next].keyframe < i) ++next;
    if (next == matches.size() && !rules.later_ones) break;
    const Match& after = matches[std::min(next, matches.size() - 1)];
    const Match& before = next == 0 || after.keyframe == i ? after : matches[next - 1];
    const double before_s = keyframes[before.keyframe].stamp_s, after_s = keyframes[after.keyframe].stamp_s;
    const double share = after_s > before_s ? (keyframes[i].stamp_s - before_s) / (after_s - before_s) : 0;
    const Pose& T_was = keyframes[i].T_local_sensor;
    const Pose T_now = between(before.T_now_was * T_was, after.T_now_was * T_was, std::min(share, 1.0));
    const Change moved = change(T_was, T_now);
    if (moved.m >= rules.least_moved_m || moved.rad >= rules.least_turned_rad)
      out.moved.push_back({i + 1, orthonormalised(T_now)});
  }
  return out;
}

}  // namespace headframe
