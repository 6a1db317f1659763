#pragma once
// All components: which sessions share a frame, and where each lies in it.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "server/atlas/alignment.hpp"

namespace headframe {

struct Placement {
  SessionId session = 0;
  Pose T_component_session = Pose::Identity();
};

/// Where a session of another component would come to lie if what is provisional were merged.
struct ProvisionalPlacement {
  SessionId session = 0;
  Pose T_component_session = Pose::Identity();
  double probability = 0;  // the least of the provisional alignments that would hold the two components together
  double awaited_m = 0;    // the longest path that one of them waits for

  bool operator==(const ProvisionalPlacement& other) const {
    return session == other.session && T_component_session.matrix() == other.T_component_session.matrix() &&
           probability == other.probability && awaited_m == other.awaited_m;
  }
};

/// How sure a placement is, by the surest way of merges from the anchor to the session: the one whose least sure merge
/// is the most probable.
struct PlacementSupport {
  SessionId session = 0;
  SessionId merged_with = 0;  // the session before it on that way; 0: it is the anchor
  double probability = 1;     // of the least sure merge on the way
  int merges = 0;             // that hold the session, in all
  double shared_m = 0;        // path shared with merged_with
  bool confirmed = false;     // the operator confirmed the merge with merged_with
  double deviation_m = 0;     // along each axis, of rock on that shared path, against the anchor
  double deviation_rad = 0;   // about each axis
};

/// id is the anchor's session id; its placement is the identity. The anchor is the session that the operator chose last
/// of those in the component; without a choice, the earliest. Placements are sorted by session.
struct Component {
  SessionId id = 0;
  std::vector<Placement> placements;
  std::vector<ProvisionalPlacement> provisional = {};  // sorted by session; not part of a revision, and not stored
  std::vector<PlacementSupport> supports = {};         // of what merges hold; as `provisional`
};

/// Null: the session is not in the component.
inline const Placement* placement_in(const Component& component, SessionId session) {
  const auto found = std::find_if(component.placements.begin(), component.placements.end(),
                                  [&](const Placement& p) { return p.session == session; });
  return found == component.placements.end() ? nullptr : &*found;
}

/// Null: no merge holds the session there.
inline const PlacementSupport* support_in(const Component& component, SessionId session) {
  const auto found = std::lower_bound(component.supports.begin(), component.supports.end(), session,
                                      [](const PlacementSupport& s, SessionId id) { return s.session < id; });
  return found == component.supports.end() || found->session != session ? nullptr : &*found;
}

/// A numbered state. The revision goes up whenever a transform between two sessions appears, changes or goes.
struct Atlas {
  std::uint64_t revision = 0;
  std::vector<Component> components;  // sorted by id; sessions that merged with none are components of one
};

}  // namespace headframe
