#pragma once

#include "server/session/ids.hpp"
#include "server/verification/verification.hpp"

namespace headframe {

/// Two sessions, the second laid on the first. Searching, registering and judging are not the same both ways, so which
/// of two is laid on which may not hang on who came first.
struct OrderedPair {
  SessionId a = 0, b = 0;
};

/// T_a_b of an ordered pair, or its inverse where the ids of the two are the other way round: alignments have a < b. It
/// works both ways.
Pose by_ids(const OrderedPair& pair, const Pose& T);
/// The same for all that is known of a placement.
Judgement by_ids(const OrderedPair& pair, Judgement judgement);

}  // namespace headframe
