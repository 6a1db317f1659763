#include "server/merge/session_frames.hpp"

#include <algorithm>

#include "server/place/odometry_jump.hpp"

namespace headframe {
namespace {

constexpr double origin_step_m = 1000;
constexpr int forgiven = 3;  // keyframes off the path

/// Whether the keyframe plausibly follows `last`.
bool sound(const Keyframe& last, const Keyframe& keyframe, std::span<const Keyframe> earlier, int left_out,
           std::string& why) {
  if (left_out > forgiven) return false;
  const auto jump = jump_between(last, keyframe, earlier);
  if (jump && left_out == 0) why = *jump;
  return !jump;
}

Pose moved(const Eigen::Vector3d& to, Pose T, const Eigen::Vector3d& from) {
  T.translation() += to - T.linear() * from;
  return T;
}

/// Applies `move` to the alignment's poses, and adds origin_m to points of a's frame.
Alignment with_poses(Alignment alignment, const Eigen::Vector3d& origin_m, const auto& move) {
  alignment.T_a_b = move(alignment.T_a_b);
  if (alignment.T_a_b_runner_up) alignment.T_a_b_runner_up = move(*alignment.T_a_b_runner_up);
  for (Change& change : alignment.changes) change.p_a += origin_m;
  return alignment;
}

}  // namespace

Keyframe SessionFrames::taken_in(SessionId session, Keyframe keyframe, std::span<const Keyframe> earlier) {
  Pose& T = keyframe.T_local_sensor;
  Frame& frame = frames_[session];
  const bool first = frame.last.sequence == 0;
  if (first) frame.origin_m = (T.translation() / origin_step_m).array().round() * origin_step_m;
  T.translation() -= frame.origin_m;
  if (first) frame.first_m = T.translation();
  const bool far = (T.translation() - frame.first_m).norm() > farthest_m;
  if (!first && (far || !sound(frame.last, keyframe, earlier, frame.left_out, frame.why))) {
    if (++frame.left_out == 1 && frame.why.empty()) frame.why = "its keyframes lie too far apart";
    T = frame.last.T_local_sensor;
    keyframe.walls = {};
    keyframe.descriptor = {};
    keyframe.point_count = 0;
    return keyframe;
  }
  frame.left_out = 0;
  frame.why.clear();
  frame.last.sequence = keyframe.sequence;
  frame.last.stamp_s = keyframe.stamp_s;
  frame.last.T_local_sensor = T;
  return keyframe;
}

void SessionFrames::come_anew(SessionId session) {
  Frame& frame = frames_[session];
  frame.last = {};
  frame.left_out = 0;
  frame.why.clear();
}

SessionCut SessionFrames::cut(SessionId session) const {
  const auto found = frames_.find(session);
  if (found == frames_.end() || found->second.left_out == 0) return {};
  const Frame& frame = found->second;
  return {frame.last.sequence + 1, frame.left_out > forgiven, frame.why};
}

Eigen::Vector3d SessionFrames::origin_m(SessionId session) const {
  const auto found = frames_.find(session);
  return found == frames_.end() ? Eigen::Vector3d::Zero() : found->second.origin_m;
}

Pose SessionFrames::local(SessionId a, SessionId b, const Pose& T_a_b) const {
  return moved(-origin_m(a), T_a_b, -origin_m(b));
}

Pose SessionFrames::given_out(SessionId a, SessionId b, const Pose& T_a_b) const {
  return moved(origin_m(a), T_a_b, origin_m(b));
}

Alignment SessionFrames::local(Alignment alignment) const {
  return with_poses(alignment, -origin_m(alignment.a),
                    [&](const Pose& T) { return local(alignment.a, alignment.b, T); });
}

Alignment SessionFrames::given_out(Alignment alignment) const {
  return with_poses(alignment, origin_m(alignment.a),
                    [&](const Pose& T) { return given_out(alignment.a, alignment.b, T); });
}

Atlas SessionFrames::given_out(Atlas atlas) const {
  for (Component& component : atlas.components) {
    const auto give_out = [&](auto& placement) {
      placement.T_component_session = given_out(component.id, placement.session, placement.T_component_session);
    };
    std::for_each(component.placements.begin(), component.placements.end(), give_out);
    std::for_each(component.provisional.begin(), component.provisional.end(), give_out);
  }
  return atlas;
}

}  // namespace headframe
