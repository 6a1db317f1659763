#pragma once

#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "server/atlas/atlas.hpp"
#include "server/atlas/frozen.hpp"
#include "server/atlas/relax.hpp"

namespace headframe {

/// How far a loop of alignments may fail to close before the weakest of them is held back.
struct LoopTolerance {
  double translation_m = 2.0;  // plus 1 % of the distance between the frames, for drift
  double rotation_rad = 0.07;  // 4 deg
};

/// Whether a transform that was found agrees with the one that a loop implies.
bool agrees(const Pose& T_loop, const Pose& T, const LoopTolerance& tolerance);

struct MergeResult {
  std::vector<Component> components;   // sorted; every session of the input is in one
  std::vector<AlignmentState> states;  // of each alignment of the input: what it is now
  std::vector<std::optional<std::pair<SessionId, SessionId>>> contradicted_by;  // the sessions that hold it back
};

/// What two sessions without an alignment of their own say of where others would put them.
enum class Contact {
  none,         // they do not meet there, or nothing can be told
  agrees,       // they see the same rock
  contradicts,  // the rays of one pass through the other's rock
  unknown,      // they meet, and it has not been looked at yet
};
using Contacts = std::function<Contact(SessionId a, SessionId b, const Pose& T_a_b)>;  // a < b

/// Sequential merging under the overlap constraint: verified alignments are taken strongest first; one that joins two
/// components merges them, unless a session of one contradicts one of the other there; one that closes a loop is
/// published when it agrees with the loop. What is not is held back: verified, or retracted if it had been published.
/// Of two that contradict each other so one is a copy as long as its overlap, and those by which the two sessions come
/// to lie on each other wait as verified unless their overlap is 1.5 times as long. While a contact is unknown, what is
/// published stays and what is not waits as verified. Strongest are those that the operator confirmed, then those that
/// close more triangles with others than they fail to close, then the more probable, aliases aside, with the less
/// probable runner-up. The published ones are then made to agree by least squares over the session frames (relax.hpp).
/// The outcome depends on the set of alignments only, not on the order they came in. Alignments in state candidate,
/// provisional, retracted or rejected are not used. Poses of a component are relative to its anchor: of `anchors`, in
/// the order they were chosen, the last that is in the component; without one its lowest session id. Where a component
/// holds frozen sessions, one of them is its anchor, chosen likewise, and those that were frozen in one frame keep
/// their places to each other (T_frame_session between the same frames as T_a_b).
MergeResult merge_sessions(std::span<const SessionId> sessions, std::span<const Alignment> alignments,
                           const LoopTolerance& tolerance = {}, std::span<const SessionId> anchors = {},
                           const Contacts& contacts = {}, const FrozenSessions& frozen = {}, const Meetings& meet = {});

}  // namespace headframe
