#pragma once

#include <optional>
#include <span>

#include "common/session/keyframe.hpp"

namespace headframe {

/// How high the frame of session b lies above that of a, in metres, if T_a_b places it as seen from above (its height
/// is ignored). Each keyframe of b tells a height together with the keyframe of a that is nearest to it seen from
/// above. Where one path runs over another, some of them stand on two levels. So of those within 4 m of each other the
/// height counts with which most agree to a metre; or, if `told_m` is given (by two keyframes that show one place), the
/// one nearest to that, to a metre. Among equals the nearest two keyframes tell it. If none come within 4 m: told_m,
/// else what the nearest two tell. 0 if a session is empty and nothing is told. Pure.
double likely_height_m(std::span<const Keyframe> a, std::span<const Keyframe> b, const Pose& T_a_b,
                       std::optional<double> told_m = std::nullopt);

}  // namespace headframe
