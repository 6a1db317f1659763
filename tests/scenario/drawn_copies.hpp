#pragma once
// Drives in mines that repeat themselves.

#include "tests/support/box_mine.hpp"

namespace headframe::test {

/// These drifts, and along the x axis blocks of 40 m that are the same.
inline BoxMine with_copies(std::vector<Box> drifts, int blocks) {
  for (int i = 0; i < blocks; ++i) {
    const double x = 20 + 40 * i;
    drifts.push_back(BoxMine::drift(x, 0, x, 12));
    drifts.push_back(BoxMine::drift(x + 7, -9, x + 7, 0, 6));
  }
  return BoxMine(drifts);
}

/// Through five blocks that are the same: what is not seen of this mine may well be another.
inline Drive drive_through_copies() {
  return drive(with_copies({BoxMine::drift(0, 0, 200, 0)}, 5), {{2, 0}, {198, 0}}, 0.7, 4);
}

/// A drift with branches that two mines have in common; some metres beyond where both robots stopped, at 88 m, one of
/// them ends. In a wide one the robots drive aside_m from its middle.
inline Drive along_copies(double end_m, double yaw_rad, unsigned seed, double width_m = 4, double aside_m = 0) {
  const BoxMine mine({BoxMine::drift(0, 0, 94, 0, width_m), BoxMine::drift(15, 0, 15, 14),
                      BoxMine::drift(42, -9, 42, 0, 6), BoxMine::drift(66, 0, 66, 20),
                      BoxMine::drift(80, -16, 80, 0, 3), BoxMine::drift(94, 0, end_m, 0, 10)});
  return drive(mine, {{2, aside_m}, {88, aside_m}}, yaw_rad, seed);
}

}  // namespace headframe::test
