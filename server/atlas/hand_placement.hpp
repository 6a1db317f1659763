#pragma once

#include "server/atlas/alignment.hpp"

namespace headframe {

/// The result of a rough placement by an operator: the pair's alignment, or only a judgement.
struct HandPlacement {
  Alignment alignment;    // after registration, with the evidence; its state follows from this placement alone
  bool recorded = false;  // it is now the pair's alignment and waits for confirmation
  double moved_m = 0;     // from where the operator put it, at the overlap
  double turned_rad = 0;
};

}  // namespace headframe
