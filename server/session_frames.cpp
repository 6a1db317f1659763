#include "server/session_frames.hpp"

namespace headframe {
namespace {

constexpr double origin_step_m = 1000;

Pose moved(const Eigen::Vector3d& to, Pose T, const Eigen::Vector3d& from) {
  T.translation() += to - T.linear() * from;
  return T;
}

Alignment with_poses(Alignment alignment, const auto& change) {
  alignment.T_a_b = change(alignment.T_a_b);
  if (alignment.T_a_b_runner_up) alignment.T_a_b_runner_up = change(*alignment.T_a_b_runner_up);
  return alignment;
}

}  // namespace

Keyframe SessionFrames::taken_in(SessionId session, Keyframe keyframe) {
  Pose& T = keyframe.T_local_sensor;
  const auto [found, first] = frames_.try_emplace(session);
  Frame& frame = found->second;
  if (first) frame.origin_m = (T.translation() / origin_step_m).array().round() * origin_step_m;
  T.translation() -= frame.origin_m;
  if (first) frame.first_m = T.translation();
  if ((T.translation() - frame.first_m).norm() > farthest_m) {
    T = frame.T_last;
    keyframe.walls = {};
    keyframe.descriptor = {};
    keyframe.point_count = 0;
  }
  frame.T_last = T;
  return keyframe;
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
  return with_poses(alignment, [&](const Pose& T) { return local(alignment.a, alignment.b, T); });
}

Alignment SessionFrames::given_out(Alignment alignment) const {
  return with_poses(alignment, [&](const Pose& T) { return given_out(alignment.a, alignment.b, T); });
}

Atlas SessionFrames::given_out(Atlas atlas) const {
  for (Component& component : atlas.components)
    for (Placement& placement : component.placements)
      placement.T_component_session = given_out(component.id, placement.session, placement.T_component_session);
  return atlas;
}

}  // namespace headframe
