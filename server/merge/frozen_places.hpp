#pragma once
// Frozen sessions between the frames of the robots, as they are stored, and near zero, as the numeric rooms want them.

#include "server/atlas/atlas.hpp"
#include "server/atlas/frozen.hpp"
#include "server/merge/session_frames.hpp"

namespace headframe {

/// Near zero: only what lies between sessions of one frame, and between places of one session, means anything then.
FrozenSession local(const FrozenSession& frozen, const SessionFrames& frames);

/// What there is to remember of a session that is frozen as it lies now. atlas, corrections: between the frames of the
/// robots. In the frame of the component's anchor where that is frozen too, else in the session's own, where its first
/// keyframe stays. Of a session that is in no component: rigid, in its own.
FrozenSession frozen_now(SessionId session, const Atlas& atlas, const Corrections& corrections,
                         const FrozenSessions& frozen);

/// Where its places lie in a component in which merging put it at T_component_session. Local, as `held`.
Correction held_correction(const FrozenSession& held, SessionId component, const Pose& T_component_session);

}  // namespace headframe
