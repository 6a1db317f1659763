#pragma once
// Sessions that are reference: the operator froze them, and nothing moves them any more.

#include <map>

#include "server/atlas/correction.hpp"

namespace headframe {

/// Where a session and its keyframes lay when it was frozen. Sessions that were frozen in one frame keep their places
/// relative to each other, whatever else their component comes to hold.
struct FrozenSession {
  SessionId session = 0;
  SessionId frame = 0;  // the session whose frame it was
  Pose T_frame_session = Pose::Identity();
  std::vector<CorrectedKeyframe> places = {};  // T_frame_session of some keyframes, as in Correction; empty: rigid
};

using FrozenSessions = std::map<SessionId, FrozenSession>;

}  // namespace headframe
