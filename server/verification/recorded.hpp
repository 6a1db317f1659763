#pragma once
// When clouds were recorded, by the robots' clocks.

#include <algorithm>

namespace headframe {

/// The time from the first to the last of some clouds, in seconds since 1970; unknown unless all of them have a date.
struct Recorded {
  double from_s = 0, to_s = 0;
  constexpr bool known() const { return from_s > 0; }
};

/// Whether a stamp is a date, between 2001 and 2128. Robots whose clock was never set count from their start, or from
/// 1970.
constexpr bool is_date(double stamp_s) { return stamp_s > 1e9 && stamp_s < 5e9; }

/// Least time between two recordings for changes of the mine to be considered.
inline constexpr double least_gap_s = 3600;

/// Time between the two; 0 if they overlap or one of them has no date.
constexpr double gap_s(const Recorded& one, const Recorded& other) {
  if (!one.known() || !other.known()) return 0;
  return std::max({0.0, one.from_s - other.to_s, other.from_s - one.to_s});
}

}  // namespace headframe
