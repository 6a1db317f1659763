#pragma once

#include <cstdint>
#include <filesystem>

#include "tests/support/box_mine.hpp"

namespace headframe::test {

/// Writes a drawn drive (one scan a keyframe of it) as a session folder that headframe-replay plays; stamps 1 s apart,
/// the first at begun_s.
void write_session(const std::filesystem::path& folder, const Drive& drive, std::int64_t begun_s = 0);

/*  y
 *  40        C
 *            |
 *   0  A ----+-----------+---- B
 *            30          60
 * -25                    D (6 m wide)                                              */
const BoxMine& branches_mine();
Drive drive_a_to_c(double spacing_m = 2);
Drive drive_b_to_a(double spacing_m = 2);
Drive drive_d_to_b(double spacing_m = 2);
/// All of the path from B to A, the other way: long enough for walls alone to tell.
Drive drive_a_to_b(double spacing_m = 2);
/// From B to C in the same mine when C has been driven on by 12 m.
Drive drive_b_to_c_driven_on(double spacing_m = 2);

/// Another mine: a drift of 80 m with two branches.
const BoxMine& other_mine();
/// Goes on with `after` as it would be told by a robot that was carried so far.
Drive carried(Drive drive, const Drive& after, const Eigen::Vector3d& by_m, double rest_s = 1);

}  // namespace headframe::test
