#pragma once
// Sessions that the operator froze: they serve as reference, and nothing moves them.

#include <map>

#include "server/atlas/correction.hpp"

namespace headframe {

/// Where a session and its keyframes lay when it was frozen. Sessions frozen in one frame keep their places relative to
/// each other, whatever else joins their component.
struct FrozenSession {
  SessionId session = 0;
  SessionId frame = 0;  // the session whose frame was used
  Pose T_frame_session = Pose::Identity();
  std::vector<CorrectedKeyframe> places = {};  // T_frame_session of some keyframes, as in Correction; empty: rigid
};

using FrozenSessions = std::map<SessionId, FrozenSession>;

}  // namespace headframe
