#pragma once

#include <functional>
#include <map>
#include <vector>

#include "server/atlas/alignment.hpp"
#include "server/atlas/frozen.hpp"

namespace headframe {

/// Sessions of one component with their poses relative to one of its sessions.
using Frames = std::map<SessionId, Pose>;

/// The point at which two sessions meet by an alignment, in b's frame.
using Meetings = std::function<Eigen::Vector3d(const Alignment&)>;

/// Least squares over the session frames of one component (the first stays fixed), with equal weight for each
/// alignment; a metre counts as much as 0.05 rad. Errors are measured at the point where the two sessions meet, not at
/// the origin of a session; so to first order the result does not depend on the choice of frames, or on which session
/// is called a. Without `meet` they are measured at b's origin. Sessions that were frozen in one frame move as one;
/// alignments between them are ignored.
void relax(Frames& frames, const std::vector<Alignment>& edges, const FrozenSessions& frozen = {},
           const Meetings& meet = {});

/// For sessions that were frozen in the same frame as another one of the component: that other session and
/// T_other_session.
std::map<SessionId, std::pair<SessionId, Pose>> frozen_together(const Frames& frames, const FrozenSessions& frozen);

}  // namespace headframe
