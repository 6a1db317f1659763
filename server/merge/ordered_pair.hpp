#pragma once

#include "server/session/ids.hpp"
#include "server/verification/verification.hpp"

namespace headframe {

/// Two sessions; b is placed on a. Searching, registering and judging are not symmetric, so the order must not depend
/// on which session arrived first (SessionMap::ordered).
struct OrderedPair {
  SessionId a = 0, b = 0;
};

/// Converts T_a_b of an ordered pair to the order of alignments (smaller id first): returns T, or its inverse if pair.a
/// > pair.b. The same call converts back.
Pose by_ids(const OrderedPair& pair, const Pose& T);
/// The same for all parts of a judgement.
Judgement by_ids(const OrderedPair& pair, Judgement judgement);

}  // namespace headframe
