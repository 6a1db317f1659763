#pragma once
// What changed in the mine, as merged sessions tell: one list for all of the atlas.

#include <vector>

#include "server/atlas/alignment.hpp"
#include "server/atlas/atlas.hpp"

namespace headframe {

/// A change where it lies on the map.
struct PlacedChange {
  AlignmentId alignment = 0;                    // that tells most narrowly when it was
  SessionId component = 0;                      // 0: its sessions lie in none; then p is in the older session's frame
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // its middle, in the component's frame
  SessionId older = 0, newer = 0;
  Change change;
};

/// The changes of one alignment, whatever its state, in its order.
std::vector<PlacedChange> changes_of(const Alignment& alignment, const Atlas& atlas);

/// Those of published alignments that may have come after since_s (seconds since 1970), the newest first. What several
/// pairs of sessions tell is listed once, between the latest session before and the earliest after. Pure.
std::vector<PlacedChange> changes_since(double since_s, const std::vector<const Alignment*>& alignments,
                                        const Atlas& atlas);

}  // namespace headframe
