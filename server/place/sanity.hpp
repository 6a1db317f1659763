#pragma once
// Does a keyframe see what the ones beside it see? A scan that was garbled, or filed under a wrong pose, does not.

#include <optional>
#include <span>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Share of b's wall points within 20 m that a sees as well, of those that a's profile can speak of: what lies behind
/// a's wall is hidden. Nothing when there are too few to tell.
std::optional<double> agreement(const Keyframe& a, const Keyframe& b);

/// Whether keyframe i sees what its neighbours see (two before, two after), nearly as well as they see it of each
/// other. True when there are too few to ask, or no profile.
bool fits_neighbours(std::span<const Keyframe> keyframes, std::size_t i);

}  // namespace headframe
