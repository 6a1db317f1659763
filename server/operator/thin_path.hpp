#pragma once

#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Those that stay of a path, in their order: the first, the last, and as many between them that each one that is left
/// out lies within tolerance_m of the straight line between its neighbours that stay, at the share of the way that its
/// sequence says. So who draws the line, or fills it with evenly spaced stand-ins, is nowhere farther off than that.
/// tolerance_m 0: all stay. Sequences rise. Takes time in proportion to the path's length, at worst 512 times that.
std::vector<Keyframe> thin_path(std::vector<Keyframe> path, double tolerance_m);

}  // namespace headframe
