#pragma once
// Checks whether a keyframe sees what its neighbours see. A corrupted scan, or one with a wrong pose, does not.

#include <optional>
#include <span>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Share of b's wall points within 20 m that a sees too. Points hidden behind a's walls do not count. Nullopt if there
/// are too few points to tell.
std::optional<double> agreement(const Keyframe& a, const Keyframe& b);

/// Whether keyframe i agrees with its neighbours (two before, two after) nearly as well as they agree with each other.
/// True if there are too few neighbours, or no profile.
bool fits_neighbours(std::span<const Keyframe> keyframes, std::size_t i);

}  // namespace headframe
