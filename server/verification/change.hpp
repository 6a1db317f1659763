#pragma once
// Changes of a mine between two sessions.

#include <cstdint>
#include <string_view>

#include "common/geometry/se3.hpp"

namespace headframe {

/// excavated: newer rays pass through older rock, which is therefore gone. filled: older rays passed through where
/// newer ones hit something.
enum class ChangeKind : std::uint8_t { excavated, filled };

std::string_view to_string(ChangeKind kind);

/// One place that changed between two sessions a and b, whose placement on each other is known.
struct Change {
  ChangeKind kind = ChangeKind::excavated;
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero();   // its middle, in a's frame
  double length_m = 0, width_m = 0, height_m = 0;  // extent of what was seen; the height is vertical
  bool a_is_newer = false;                         // ... than b
  double older_s = 0, newer_s = 0;                 // it changed between these, seconds since 1970
};

/// The same change described from b, for a placement T_a_b: the roles of a and b are exchanged.
Change seen_from_b(Change change, const Pose& T_a_b);

}  // namespace headframe
