#pragma once
// All components: which sessions share a frame, and the transform of each.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "server/atlas/alignment.hpp"

namespace headframe {

struct Placement {
  SessionId session = 0;
  Pose T_component_session = Pose::Identity();
};

/// Where a session of another component would lie if the provisional alignments were merged.
struct ProvisionalPlacement {
  SessionId session = 0;
  Pose T_component_session = Pose::Identity();
  double probability = 0;  // of the least probable provisional alignment that would connect the two components
  double awaited_m = 0;    // longest path that one of these waits for

  bool operator==(const ProvisionalPlacement& other) const {
    return session == other.session && T_component_session.matrix() == other.T_component_session.matrix() &&
           probability == other.probability && awaited_m == other.awaited_m;
  }
};

/// How reliable a placement is: along the most reliable chain of merges from the anchor to the session, which is the
/// chain whose least probable merge is the most probable.
struct PlacementSupport {
  SessionId session = 0;
  SessionId merged_with = 0;  // the session before it on the chain; 0: it is the anchor
  double probability = 1;     // of the least probable merge on the chain
  int merges = 0;             // number of merges of the session
  double shared_m = 0;        // path shared with merged_with
  bool confirmed = false;     // the operator confirmed the merge with merged_with
  double deviation_m = 0;    // standard deviation on each axis, for rock along that shared path, relative to the anchor
  double deviation_rad = 0;  // about each axis
};

/// id is the anchor's session id; its placement is the identity. The anchor is the session of the component that the
/// operator chose last; if none was chosen, the earliest. Placements are sorted by session.
struct Component {
  SessionId id = 0;
  std::vector<Placement> placements;
  std::vector<ProvisionalPlacement> provisional = {};  // sorted by session; not part of a revision, and not stored
  std::vector<PlacementSupport> supports = {};         // for merged sessions; not stored either
};

/// Null if the session is not in the component.
inline const Placement* placement_in(const Component& component, SessionId session) {
  const auto found = std::find_if(component.placements.begin(), component.placements.end(),
                                  [&](const Placement& p) { return p.session == session; });
  return found == component.placements.end() ? nullptr : &*found;
}

/// Null if no merge connects the session.
inline const PlacementSupport* support_in(const Component& component, SessionId session) {
  const auto found = std::lower_bound(component.supports.begin(), component.supports.end(), session,
                                      [](const PlacementSupport& s, SessionId id) { return s.session < id; });
  return found == component.supports.end() || found->session != session ? nullptr : &*found;
}

/// A numbered state. The revision increases whenever a transform between two sessions appears, changes or disappears.
struct Atlas {
  std::uint64_t revision = 0;
  std::vector<Component> components;  // sorted by id; a session that is not merged is a component of its own
};

}  // namespace headframe
