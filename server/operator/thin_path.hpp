#pragma once

#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Thins a path and keeps the order: the first and last keyframe stay, and as many between them that each removed one
/// lies within tolerance_m of the straight line between its remaining neighbours, at the fraction given by its sequence
/// number. So a line drawn through the result, or filled with evenly spaced positions, deviates by no more than that.
/// With tolerance_m 0 all keyframes stay. Sequence numbers must rise. The time is linear in the path's length; a
/// crooked path takes up to 512 times as long as a straight one.
std::vector<Keyframe> thin_path(std::vector<Keyframe> path, double tolerance_m);

}  // namespace headframe
