#pragma once

#include <set>
#include <span>

#include "server/atlas/merge_graph.hpp"

namespace headframe {

/// Which alignments are in doubt because a candidate may be right in their place. An alignment of places that look
/// alike (evidence.similar_places is look_alikes or more, no ruling) cannot be right together with a candidate that
/// shares one of its sessions, if their other sessions contradict each other where both alignments would bring them.
/// One of the two is a copy then, and the better one nearly as often as the other, unless the candidate's share of its
/// odds is below that of a runner-up (thresholds.runner_up_share), or its overlap is clearly longer. One that is not
/// published yet is in doubt, too, until these sessions are compared. `present`: the sessions that are not set aside;
/// candidates of others have no say.
Doubts rivalled(std::span<const Alignment> alignments, const VerdictThresholds& thresholds, double look_alikes,
                const std::set<SessionId>& present, const Contacts& contacts);

}  // namespace headframe
