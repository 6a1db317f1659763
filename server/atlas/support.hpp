#pragma once

#include <span>

#include "server/atlas/atlas.hpp"

namespace headframe {

/// Says of each component of several sessions how sure its placements are, by the published ones of the alignments.
/// Pure; what Component::supports held before is replaced.
void add_supports(Atlas& atlas, std::span<const Alignment> alignments);

}  // namespace headframe
