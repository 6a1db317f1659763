#pragma once

#include <string>
#include <string_view>

#include "server/atlas/pose_constraint.hpp"

namespace headframe {

/// 296 bytes each: session and sequence of both keyframes (64 bit), T_from_to as 12 doubles, and the upper half of the
/// information, row by row; little endian. Empty: null.
std::string constraints_blob(const PoseConstraints& constraints);

/// Null when the blob is empty, or of another size than constraints_blob gives.
PoseConstraints constraints_from_blob(std::string_view blob);

}  // namespace headframe
