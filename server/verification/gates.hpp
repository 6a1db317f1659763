#pragma once

namespace headframe {

/// Gravity disagrees by more than this at no right placement.
inline constexpr double most_tilt_deg = 3;

}  // namespace headframe
