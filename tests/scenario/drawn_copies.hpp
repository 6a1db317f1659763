#pragma once
// Drives in mines that repeat themselves.

#include "tests/support/box_mine.hpp"

namespace headframe::test {

/// Through five blocks that are the same: what is not seen of this mine may well be another.
inline Drive drive_through_copies() {
  std::vector<Box> drifts{BoxMine::drift(0, 0, 200, 0)};
  for (double x = 20; x < 200; x += 40) {
    drifts.push_back(BoxMine::drift(x, 0, x, 12));
    drifts.push_back(BoxMine::drift(x + 7, -9, x + 7, 0, 6));
  }
  return drive(BoxMine(drifts), {{2, 0}, {198, 0}}, 0.7, 4);
}

/// A drift with branches that two mines have in common; 19 m beyond where both robots stopped one of them ends.
inline Drive along_copies(double end_m, double yaw_rad, unsigned seed) {
  const BoxMine mine({BoxMine::drift(0, 0, 94, 0), BoxMine::drift(15, 0, 15, 14), BoxMine::drift(42, -9, 42, 0, 6),
                      BoxMine::drift(66, 0, 66, 20), BoxMine::drift(80, -16, 80, 0, 3),
                      BoxMine::drift(94, 0, end_m, 0, 10)});
  return drive(mine, {{2, 0}, {88, 0}}, yaw_rad, seed);
}

}  // namespace headframe::test
