#pragma once
// Where the pose graph puts the keyframes of a session.

#include <map>
#include <memory>
#include <vector>

#include "common/geometry/se3.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Where one keyframe came to lie: T_component_session takes its pose in the session's frame to that in the
/// component's.
struct CorrectedKeyframe {
  std::uint64_t sequence = 0;
  Pose T_component_session = Pose::Identity();
};

/// Of one session: some of its keyframes, in the order of their sequence. Those between follow the two beside them.
struct Correction {
  SessionId component = 0;
  std::vector<CorrectedKeyframe> keyframes;  // at least one

  /// T_component_sensor of any keyframe, from its pose in the session's frame. Between two, the poses that both would
  /// give are blended by the keyframe's number; before the first and behind the last it is rigid.
  Pose corrected(std::uint64_t sequence, const Pose& T_local_sensor) const;
};

/// Of the sessions that have one; the others are rigid. Immutable and shared.
using Corrections = std::map<SessionId, std::shared_ptr<const Correction>>;

}  // namespace headframe
