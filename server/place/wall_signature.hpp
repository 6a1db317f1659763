#pragma once

#include <optional>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// A rotation-invariant signature of a wall profile: the square roots of the magnitudes of the first 24 harmonics of
/// its 180 codes. Sectors without a return take the profile's farthest range. It compares keyframes of any descriptor
/// families, less reliably than place vectors. Nullopt if fewer than 20 sectors have a return.
constexpr std::size_t wall_signature_size = 24;
std::optional<std::vector<float>> wall_signature(const WallProfile& walls);

}  // namespace headframe
