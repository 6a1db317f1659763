#pragma once
// When things were recorded, by the robots' clocks.

#include <algorithm>

namespace headframe {

/// From the first to the last of some clouds, in seconds since 1970; nothing unless all of them have a date.
struct Recorded {
  double from_s = 0, to_s = 0;
  constexpr bool known() const { return from_s > 0; }
};

/// Whether a stamp is a date. Robots whose clock was never set count from their start, or from 1970; what lies before
/// 2001 or after 2128 is neither.
constexpr bool is_date(double stamp_s) { return stamp_s > 1e9 && stamp_s < 5e9; }

/// So long there is between two recordings when a mine may have changed. Two sessions of one hour see one mine.
inline constexpr double least_gap_s = 3600;

/// Time between the two; 0 where they overlap, or where one has no date.
constexpr double gap_s(const Recorded& one, const Recorded& other) {
  if (!one.known() || !other.known()) return 0;
  return std::max({0.0, one.from_s - other.to_s, other.from_s - one.to_s});
}

}  // namespace headframe
