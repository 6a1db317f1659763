#pragma once

#include <map>
#include <vector>

#include "server/atlas/alignment.hpp"
#include "server/atlas/frozen.hpp"

namespace headframe {

/// Sessions of one component with their poses relative to some member.
using Frames = std::map<SessionId, Pose>;

/// Least squares over the session frames of one component (the first stays), each alignment with equal weight: a metre
/// counts as much as 0.05 rad. Sessions that were frozen in one frame keep their places relative to each other: what
/// alignments between them say does not count, and they move as one.
void relax(Frames& frames, const std::vector<Alignment>& edges, const FrozenSessions& frozen = {});

/// Of those that were frozen in the same frame as another of the component: that other one, and T_other_session.
std::map<SessionId, std::pair<SessionId, Pose>> frozen_together(const Frames& frames, const FrozenSessions& frozen);

}  // namespace headframe
