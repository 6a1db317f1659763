#pragma once

#include <string>
#include <string_view>

#include "server/atlas/pose_constraint.hpp"

namespace headframe {

/// 296 bytes for each constraint: session and sequence of both keyframes (64 bit), T_from_to as 12 doubles, and the
/// upper triangle of the information, row by row; little endian. Empty if `constraints` is null.
std::string constraints_blob(const PoseConstraints& constraints);

/// Null if the blob is empty, or does not have a size that constraints_blob gives.
PoseConstraints constraints_from_blob(std::string_view blob);

}  // namespace headframe
