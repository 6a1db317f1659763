#include "server/merge/frozen_places.hpp"

namespace headframe {

FrozenSession local(const FrozenSession& frozen, const SessionFrames& frames) {
  constexpr SessionId at_zero = 0;  // not a session: the frame's own origin cancels between any two
  FrozenSession out = frozen;
  out.T_frame_session = frames.local(at_zero, frozen.session, frozen.T_frame_session);
  for (CorrectedKeyframe& place : out.places)
    place.T_component_session = frames.local(at_zero, frozen.session, place.T_component_session);
  return out;
}

FrozenSession frozen_now(SessionId session, const Atlas& atlas, const Corrections& corrections,
                         const FrozenSessions& frozen) {
  FrozenSession out{session, session};
  if (const auto bent = corrections.find(session); bent != corrections.end()) out.places = bent->second->keyframes;
  Pose T_frame_component = Pose::Identity();
  bool joins = false;
  for (const Component& component : atlas.components) {
    const Placement* placed = placement_in(component, session);
    const auto anchor = frozen.find(component.id);
    if (!placed || anchor == frozen.end()) continue;
    joins = true;
    out.frame = anchor->second.frame;
    T_frame_component = anchor->second.T_frame_session;
    out.T_frame_session = orthonormalised(T_frame_component * placed->T_component_session);
  }
  if (!joins && !out.places.empty()) T_frame_component = out.places.front().T_component_session.inverse();
  for (CorrectedKeyframe& place : out.places)
    place.T_component_session = orthonormalised(T_frame_component * place.T_component_session);
  return out;
}

Correction held_correction(const FrozenSession& held, SessionId component, const Pose& T_component_session) {
  Correction out{component, held.places};
  if (out.keyframes.empty()) out.keyframes.push_back({1, held.T_frame_session});
  const Pose T_component_frame = T_component_session * held.T_frame_session.inverse();
  for (CorrectedKeyframe& place : out.keyframes)
    place.T_component_session = orthonormalised(T_component_frame * place.T_component_session);
  return out;
}

}  // namespace headframe
