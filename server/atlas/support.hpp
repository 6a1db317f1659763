#pragma once

#include <span>

#include "server/atlas/atlas.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// One standard deviation of where a merge lays one session on another.
struct MergeDeviation {
  double metres = 0, radians = 0;
};

/// From how far the places of the overlap would have moved by themselves, each registered alone; the floors by hand.
MergeDeviation deviation_of(const Evidence& evidence);

/// Says of each component of several sessions how sure its placements are, by the published ones of the alignments.
/// Pure; what Component::supports held before is replaced.
void add_supports(Atlas& atlas, std::span<const Alignment> alignments);

}  // namespace headframe
