#pragma once
// What became of a mine between two sessions.

#include <cstdint>
#include <string_view>

#include "common/geometry/se3.hpp"

namespace headframe {

/// excavated: newer rays pass through older rock, so that it is gone. filled: older rays passed through where newer
/// ones meet something.
enum class ChangeKind : std::uint8_t { excavated, filled };

std::string_view to_string(ChangeKind kind);

/// One place that changed between two sessions a and b that lie on each other.
struct Change {
  ChangeKind kind = ChangeKind::excavated;
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero();   // its middle, in a's frame
  double length_m = 0, width_m = 0, height_m = 0;  // of what is gone or new, as far as it was seen: level, upright
  bool a_is_newer = false;                         // ... than b
  double older_s = 0, newer_s = 0;                 // it changed between these, seconds since 1970
};

/// The same with the two sessions the other way round, where b lies at T_a_b on a.
Change seen_from_b(Change change, const Pose& T_a_b);

}  // namespace headframe
