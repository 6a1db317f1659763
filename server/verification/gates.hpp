#pragma once

namespace headframe {

/// No right placement disagrees about gravity by more than this.
inline constexpr double most_tilt_deg = 3;

}  // namespace headframe
