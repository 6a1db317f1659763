#pragma once
// When two placements of a pair of sessions count as the same, for different purposes.

#include <numbers>

#include "common/geometry/se3.hpp"

namespace headframe {

/// The greatest distance at which two placements may put a point of the overlap, and their greatest relative rotation.
struct PlacementTolerance {
  double metres = 0;
  double radians = 0;
};

/// Whether T and U (both T_a_b) put p_b, a point near the overlap in b's frame, within the tolerance of each other.
inline bool same_placement(const Pose& T, const Pose& U, const Eigen::Vector3d& p_b, const PlacementTolerance& within) {
  return (T * p_b - U * p_b).norm() <= within.metres && rotation_angle_rad(T.inverse() * U) <= within.radians;
}

/// Two hypotheses from any method, before registration: horizontal, and as coarse as a cell of the wall maps.
inline constexpr PlacementTolerance same_hypothesis{4, 15 * std::numbers::pi / 180};
/// Two peaks of one correlation of wall maps.
inline constexpr PlacementTolerance same_wall_peak{4, 12 * std::numbers::pi / 180};
/// Two registrations: if they end this close to each other, they found the same placement.
inline constexpr PlacementTolerance same_registration{2, 0.12};
/// A placement and its rival: the rival has to differ by more than this.
inline constexpr PlacementTolerance same_as_rival{2, 0.17};
/// A placement on which the operator has decided, found again by a later attempt.
inline constexpr PlacementTolerance same_as_ruled{2, 10 * std::numbers::pi / 180};
/// Two placements at which a place looks like a copy.
inline constexpr PlacementTolerance same_look_alike{4, 0.3};
/// A session placed on itself, and the identity.
inline constexpr PlacementTolerance same_as_itself{6, 0.5};
/// A placement implied by other alignments, from one update of the atlas to the next; they drift.
inline constexpr PlacementTolerance same_contact{1, 0.03};
/// Smaller changes of a transform are not told to the robots.
inline constexpr PlacementTolerance same_to_robots{0.05, 0.2 * std::numbers::pi / 180};
/// The same for sessions that have ended: tighter, so that a merge gives the same transform however it came about.
inline constexpr PlacementTolerance same_when_settled{0.01, 0.05 * std::numbers::pi / 180};
/// Rounding only.
inline constexpr PlacementTolerance same_numbers{1e-6, 1e-6};

}  // namespace headframe
