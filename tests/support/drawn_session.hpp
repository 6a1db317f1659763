#pragma once

#include <filesystem>

#include "tests/support/box_mine.hpp"

namespace headframe::test {

/// Writes a drawn drive (one scan a keyframe of it) as a session folder that headframe-replay plays; stamps 1 s apart.
void write_session(const std::filesystem::path& folder, const Drive& drive);

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

}  // namespace headframe::test
