#pragma once
// How evidence is weighed gradually, without cliffs.

#include <algorithm>

namespace headframe {

/// 0 up to `none`, 1 from `all` on, linear between them; `all` may be the lesser.
inline double ramp(double value, double none, double all) {
  return std::clamp((value - none) / (all - none), 0.0, 1.0);
}

}  // namespace headframe
