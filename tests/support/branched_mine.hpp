#pragma once

#include "tests/support/box_mine.hpp"

namespace headframe::test {

/*  y    A tunnel of 110 m with branches that differ, and a room
 *  20              |
 *  14    |         |
 *   0 ===+====+====+===+====+==[room]
 *  -9         |
 * -16                  |                                  */
inline const BoxMine& branched_mine() {
  static const BoxMine drawn({BoxMine::drift(0, 0, 110, 0), BoxMine::drift(15, 0, 15, 14),
                              BoxMine::drift(32, -9, 32, 0, 6), BoxMine::drift(47, 0, 47, 20),
                              BoxMine::drift(61, -16, 61, 0, 3), BoxMine::drift(74, 0, 74, 9, 7),
                              BoxMine::drift(98, 0, 110, 0, 14)});
  return drawn;
}

/// From one end to the other: all of it.
inline Drive drive_that_maps(double spacing_m = 3) {
  return drive(branched_mine(), {{2, 0}, {108, 0}}, 0.7, 4, spacing_m);
}

/// So much of it, the other way: a robot that wakes up there. A tunnel of one width looks like itself, so it takes long
/// until it is told where.
inline Drive drive_that_wakes_up(double spacing_m = 4, double metres = 70) {
  return drive(branched_mine(), {{106, 0}, {106 - metres, 0}}, -2, 9, spacing_m);
}

/// 42 m through other rock.
inline Drive drive_elsewhere(double spacing_m = 6) {
  const BoxMine elsewhere(
      {BoxMine::drift(0, 0, 60, 0, 5), BoxMine::drift(22, 0, 22, 25, 5), BoxMine::drift(40, -12, 40, 0, 8)});
  return drive(elsewhere, {{2, 0}, {44, 0}}, 1, 5, spacing_m);
}

}  // namespace headframe::test
