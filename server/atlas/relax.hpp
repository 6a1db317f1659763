#pragma once

#include <functional>
#include <map>
#include <vector>

#include "server/atlas/alignment.hpp"
#include "server/atlas/frozen.hpp"

namespace headframe {

/// Sessions of one component with their poses relative to some member.
using Frames = std::map<SessionId, Pose>;

/// Where two sessions meet by an alignment, in b's frame.
using Meetings = std::function<Eigen::Vector3d(const Alignment&)>;

/// Least squares over the session frames of one component (the first stays), each alignment with equal weight: a metre
/// counts as much as 0.05 rad. An error is that of where the two meet, not of where a session happens to begin: so it
/// is, to first order, the same in whatever frames they came, and whichever of the two is called a. Without `meet` it
/// is that of b's origin. Sessions that were frozen in one frame keep their places relative to each other: what
/// alignments between them say does not count, and they move as one.
void relax(Frames& frames, const std::vector<Alignment>& edges, const FrozenSessions& frozen = {},
           const Meetings& meet = {});

/// Of those that were frozen in the same frame as another of the component: that other one, and T_other_session.
std::map<SessionId, std::pair<SessionId, Pose>> frozen_together(const Frames& frames, const FrozenSessions& frozen);

}  // namespace headframe
