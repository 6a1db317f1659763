#pragma once
// Changes of the mine between merged sessions, as one list for the whole atlas.

#include <vector>

#include "server/atlas/alignment.hpp"
#include "server/atlas/atlas.hpp"

namespace headframe {

/// A change with its position on the map.
struct PlacedChange {
  AlignmentId alignment = 0;  // the one that dates it most precisely
  SessionId component = 0;    // 0: its sessions are in no component; then p is in the older session's frame
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // its middle, in the component's frame
  SessionId older = 0, newer = 0;
  Change change;
};

/// The changes of one alignment, whatever its state, in its order.
std::vector<PlacedChange> changes_of(const Alignment& alignment, const Atlas& atlas);

/// The changes of published alignments that may have happened after since_s (seconds since 1970), newest first. A
/// change seen by several pairs of sessions is listed once, dated between the latest session before and the earliest
/// after it. Pure.
std::vector<PlacedChange> changes_since(double since_s, const std::vector<const Alignment*>& alignments,
                                        const Atlas& atlas);

}  // namespace headframe
