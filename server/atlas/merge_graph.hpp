#pragma once

#include <functional>
#include <map>
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

/// Whether a transform agrees with the one that a loop implies.
bool agrees(const Pose& T_loop, const Pose& T, const LoopTolerance& tolerance);

struct MergeResult {
  std::vector<Component> components;   // sorted; every session of the input is in one
  std::vector<AlignmentState> states;  // the new state of each alignment of the input
  std::vector<std::optional<std::pair<SessionId, SessionId>>> contradicted_by;  // the sessions that hold it back
};

/// What is known of two sessions without an alignment of their own, at the placement that other alignments imply.
enum class Contact {
  none,         // they do not meet there, or nothing can be said
  agrees,       // they see the same rock
  contradicts,  // the rays of one pass through the other's rock
  unknown,      // they meet, but were not compared yet
};
using Contacts = std::function<Contact(SessionId a, SessionId b, const Pose& T_a_b)>;  // a < b

/// Alignments in doubt, by index, each with two sessions that would contradict each other; nullopt while that is not
/// known.
using Doubts = std::map<std::size_t, std::optional<std::pair<SessionId, SessionId>>>;

/// An overlap this many times as long as another is not taken for its copy. Set by hand on drawn mines of copies, seeds
/// from 70000 on.
inline constexpr double clearly_longer = 1.5;

/// Sequential merging under the overlap constraint. Verified alignments are taken strongest first. One that joins two
/// components merges them, unless a session of one contradicts a session of the other there. One that closes a loop is
/// published if it agrees with the loop. All others are held back: verified, or retracted if they had been published.
/// If two sessions contradict each other, one of the alignments that connect them is wrong: a copy as long as its
/// overlap. So all of these alignments wait as verified, except those with an overlap at least 1.5 times as long as the
/// others'. So do those in `doubts` (rivals.hpp). While a contact is unknown, published alignments stay and others wait
/// as verified.
/// Strongest are those that the operator confirmed; then those that close more triangles with others than they fail to
/// close; then the more probable ones (not counting aliases) with the less probable runner-up. The published alignments
/// are finally made consistent by least squares over the session frames (relax.hpp).
/// The result depends only on the set of alignments, not on their order. Alignments in state candidate, provisional,
/// retracted or rejected are not used. Poses of a component are relative to its anchor: of `anchors`, in the order they
/// were chosen, the last one that is in the component; without one, its lowest session id. In a component with frozen
/// sessions the anchor is one of these, chosen in the same way, and those frozen in one frame keep their relative
/// places (T_frame_session, between the same frames as T_a_b).
MergeResult merge_sessions(std::span<const SessionId> sessions, std::span<const Alignment> alignments,
                           const LoopTolerance& tolerance = {}, std::span<const SessionId> anchors = {},
                           const Contacts& contacts = {}, const FrozenSessions& frozen = {}, const Meetings& meet = {},
                           Doubts doubts = {});

}  // namespace headframe
