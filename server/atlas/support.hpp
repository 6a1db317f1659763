#pragma once

#include <span>

#include "server/atlas/atlas.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// Standard deviation of a merge's transform.
struct MergeDeviation {
  double metres = 0, radians = 0;
};

/// From how much the places' own registrations differ from the common transform; the lower bounds are set by hand.
MergeDeviation deviation_of(const Evidence& evidence);

/// Sets Component::supports of each component of several sessions, from the published alignments. Pure; replaces
/// earlier values.
void add_supports(Atlas& atlas, std::span<const Alignment> alignments);

}  // namespace headframe
