#pragma once
// Converts a sensor's intensities to the 0 to 255 that clouds use. Pure.

#include <vector>

#include "common/cloud/point_cloud.hpp"

namespace headframe {

/// Sensors and files give intensities from 0 to 1, to 255 or to 65535 without saying which. One rule for all, for the
/// scans of one session in order: the full scale is 1 at first. It becomes 255 or 65535, for good, with the first scan
/// in which more than a hundredth of the returns exceed it. Values above it are clamped. The scales to 1 and to 255 are
/// linear; from 0 to 65535, where most returns are faint, the square root is used. Negative numbers and NaN count as 0.
/// Not thread safe.
class IntensityScale {
 public:
  /// The intensities of the next scan. Empty if all are 0, which drivers write if they have none.
  Intensities scaled(const std::vector<float>& raw);

 private:
  float full_ = 1;
};

}  // namespace headframe
