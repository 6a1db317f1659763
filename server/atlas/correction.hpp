#pragma once
// The poses that the pose graph gives to the keyframes of a session.

#include <map>
#include <memory>
#include <vector>

#include "common/geometry/se3.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// One keyframe: T_component_session maps its pose in the session's frame to its corrected pose in the component's.
struct CorrectedKeyframe {
  std::uint64_t sequence = 0;
  Pose T_component_session = Pose::Identity();
};

/// The corrections of some keyframes of one session, in order of sequence. Those between are interpolated.
struct Correction {
  SessionId component = 0;
  std::vector<CorrectedKeyframe> keyframes;  // at least one

  /// T_component_sensor of any keyframe, from its pose in the session's frame. Between two corrected keyframes the
  /// poses that both would give are blended by keyframe number; before the first and after the last the nearest one
  /// applies.
  Pose corrected(std::uint64_t sequence, const Pose& T_local_sensor) const;
};

/// For sessions that have corrections; all others are rigid. Immutable and shared.
using Corrections = std::map<SessionId, std::shared_ptr<const Correction>>;

}  // namespace headframe
