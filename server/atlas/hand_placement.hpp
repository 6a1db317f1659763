#pragma once

#include "server/atlas/alignment.hpp"

namespace headframe {

/// What came of a placement that an operator made roughly. As an alignment that is known, or only as it was judged.
struct HandPlacement {
  Alignment alignment;    // where registration put it, and the evidence; its state is what this alone says
  bool recorded = false;  // it is the pair's alignment now, and waits for a confirmation
  double moved_m = 0;     // from where the operator put it, where the two meet
  double turned_rad = 0;
};

}  // namespace headframe
