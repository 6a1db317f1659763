#pragma once

#include "common/session/keyframe.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// A keyframe on a straight line along x, step_m after the one before, whose numbers all differ from the defaults.
inline Keyframe line_keyframe(std::uint64_t sequence, double step_m = 1.0) {
  Keyframe k;
  k.sequence = sequence;
  k.stamp_s = 100.0 + 0.1 * static_cast<double>(sequence);
  k.T_local_sensor = pose_from_yaw(0.3, {step_m * static_cast<double>(sequence), 0.5, -0.25});
  k.spaciousness_m = 3.5F;
  k.descriptor.q = {0.5F, 1.5F, static_cast<float>(sequence % 1000)};
  k.descriptor.w = {0.25F, -2.0F};
  k.descriptor.place_class = PlaceClass::tunnel;
  k.walls.code[7] = 42;
  k.point_count = 1000;
  return k;
}

inline SessionRecord session_record(SessionId id, const std::string& robot) {
  return {id, {robot, "s1"}, {"os1-32", 32, 22.5F, 22.5F, 120.0F}, {"scan_context", 1}, 3, 2, 77};
}

}  // namespace headframe
