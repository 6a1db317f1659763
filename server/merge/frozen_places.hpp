#pragma once
// Frozen sessions: conversion between the robots' frames, in which they are stored, and the local frames near zero.

#include "server/atlas/atlas.hpp"
#include "server/atlas/frozen.hpp"
#include "server/merge/session_frames.hpp"

namespace headframe {

/// Converts to local frames. Only transforms between sessions and between keyframes are meaningful then.
FrozenSession local(const FrozenSession& frozen, const SessionFrames& frames);

/// The record to store for a session that is frozen as it lies now. atlas, corrections: in the robots' frames. The
/// record is in the frame of the component's anchor if that is frozen too; otherwise in the session's own frame, in
/// which its first keyframe stays. For a session that is in no component: rigid, in its own frame.
FrozenSession frozen_now(SessionId session, const Atlas& atlas, const Corrections& corrections,
                         const FrozenSessions& frozen);

/// Where its keyframes lie in a component in which merging put it at T_component_session. In local frames, like `held`.
Correction held_correction(const FrozenSession& held, SessionId component, const Pose& T_component_session);

}  // namespace headframe
