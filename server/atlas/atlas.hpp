#pragma once
// All components: which sessions share a frame, and where each lies in it.

#include <cstdint>
#include <vector>

#include "server/atlas/alignment.hpp"

namespace headframe {

struct Placement {
  SessionId session = 0;
  Pose T_component_session = Pose::Identity();
};

/// id is the anchor's session id; its placement is the identity. The anchor is the session that the operator chose last
/// of those in the component; without a choice, the earliest. Placements are sorted by session.
struct Component {
  SessionId id = 0;
  std::vector<Placement> placements;
};

/// A numbered state. The revision goes up whenever a transform between two sessions appears, changes or goes.
struct Atlas {
  std::uint64_t revision = 0;
  std::vector<Component> components;  // sorted by id; sessions that merged with none are components of one
};

}  // namespace headframe
