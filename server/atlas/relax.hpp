#pragma once

#include <map>
#include <vector>

#include "server/atlas/alignment.hpp"

namespace headframe {

/// Sessions of one component with their poses relative to some member.
using Frames = std::map<SessionId, Pose>;

/// Least squares over the session frames of one component (the first stays), each alignment with equal weight: a metre
/// counts as much as 0.05 rad.
void relax(Frames& frames, const std::vector<Alignment>& edges);

}  // namespace headframe
