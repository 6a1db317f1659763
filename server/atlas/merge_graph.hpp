#pragma once

#include <span>
#include <vector>

#include "server/atlas/atlas.hpp"

namespace headframe {

/// How far a loop of alignments may fail to close before the weakest of them is held back.
struct LoopTolerance {
  double translation_m = 2.0;  // plus 1 % of the distance between the frames, for drift
  double rotation_rad = 0.07;  // 4 deg
};

struct MergeResult {
  std::vector<Component> components;   // sorted; every session of the input is in one
  std::vector<AlignmentState> states;  // of each alignment of the input: what it is now
};

/// Sequential merging under the overlap constraint: verified alignments are taken strongest first; one that joins two
/// components merges them; one that closes a loop is published when it agrees with the loop, and held back (verified,
/// or retracted if it had been published) when it does not. Strongest are those that the operator confirmed, then those
/// that close more triangles with others than they fail to close, then the more probable. The published ones are then
/// made to agree by least squares over the session frames. The outcome depends on the set of alignments only, not on
/// the order they came in. Alignments in state candidate, retracted or rejected are not used. Poses of a component are
/// relative to its anchor: of `anchors`, in the order they were chosen, the last that is in the component; without one
/// its lowest session id.
MergeResult merge_sessions(std::span<const SessionId> sessions, std::span<const Alignment> alignments,
                           const LoopTolerance& tolerance = {}, std::span<const SessionId> anchors = {});

}  // namespace headframe
