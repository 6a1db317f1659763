#pragma once
// One place of an overlap as it was registered by itself: what the pose graph learns from it.

#include "server/registration/registration.hpp"

namespace headframe {

struct PlaceFit {
  Pose T_a_b = Pose::Identity();  // there
  Eigen::Vector3d about = Eigen::Vector3d::Zero();
  /// Of a left increment of T_a_b that turns about `about`, a point of a's frame; rotation first (1/rad^2, 1/m^2). What
  /// a registration does not hold has none.
  Matrix6d information = Matrix6d::Zero();
};

/// From a registration of b's keyframe on a's. Points near each other share their errors, so their sum is not taken at
/// its word: it is scaled so that a place whose surfaces face all ways alike is known to within place_sigma_m. What few
/// surfaces hold is off by more than their noise and counts by its hold squared: along a tunnel with a tenth of the
/// surfaces across it 13 cm. Free directions, and those along which ribs of a tunnel catch (held_well), are left open.
PlaceFit place_fit(const Registration& registration);

/// Standard deviation of each axis.
inline constexpr double place_sigma_m = 0.04;

}  // namespace headframe
