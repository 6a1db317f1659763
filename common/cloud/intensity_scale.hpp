#pragma once
// From what a sensor calls intensity to the 0 to 255 that clouds carry. Pure.

#include <vector>

#include "common/cloud/point_cloud.hpp"

namespace headframe {

/// Sensors and files write intensities from 0 to 1, to 255 or to 65535 and do not say which. This is the one rule for
/// all of them, for the scans of one session in their order: the full scale is 1 at first, and becomes 255 or 65535,
/// for good, with the first scan of which more than a hundredth of the returns are over it. Values over it are clamped.
/// From 0 to 1 and from 0 to 255 the scale is linear; of 0 to 65535, where most returns are faint, the square root is
/// taken. What is negative or no number counts as 0. Not thread safe.
class IntensityScale {
 public:
  /// Of one scan, in its order. Empty when all are 0: drivers write that where there are none.
  Intensities scaled(const std::vector<float>& raw);

 private:
  float full_ = 1;
};

}  // namespace headframe
