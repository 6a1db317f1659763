#pragma once
// The registration of one place of an overlap, as a measurement for the pose graph.

#include "server/registration/registration.hpp"

namespace headframe {

struct PlaceFit {
  Pose T_a_b = Pose::Identity();  // at this place
  Eigen::Vector3d about = Eigen::Vector3d::Zero();
  /// For a left increment of T_a_b, rotation first (1/rad^2, 1/m^2), which turns about `about`, a point in a's frame.
  /// Zero in directions that the registration does not hold.
  Matrix6d information = Matrix6d::Zero();
};

/// From a registration of b's keyframe on a's. The errors of neighbouring points are correlated, so the information is
/// rescaled: a place whose surfaces face all directions equally is known to place_sigma_m on each axis. A direction
/// held by few surfaces has errors beyond their noise; its information is scaled by the square of its hold: 13 cm along
/// a tunnel if a tenth of the surfaces face along it. Free directions, and those in which repeating ribs may mislead
/// (hold below held_well), get no information.
PlaceFit place_fit(const Registration& registration);

/// Standard deviation on each axis.
inline constexpr double place_sigma_m = 0.04;

}  // namespace headframe
