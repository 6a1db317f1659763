// headframe-drawn-sessions: session folders for tests that play them with headframe-replay from outside C++.

#include <cstdio>

#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

constexpr std::int64_t first_day_s = 1'700'000'000, month_s = 30 * 86'400;

/// DIR/a, b and c meet at the crossings of one mine; DIR/short_0 to short_49 are a few metres each. DIR/before and
/// DIR/after are a month apart, and a face was driven on between them; they share 66 m, as mines of boxes are alike
/// wherever they are straight. DIR/carried is of a robot that was carried from one mine to another.
void write_all(const std::filesystem::path& dir) {
  write_session(dir / "a", drive_a_to_c(1));
  write_session(dir / "b", drive_b_to_a(1));
  write_session(dir / "c", drive_d_to_b(1));
  write_session(dir / "before", drive(branches_mine(), {{58, 0}, {30, 0}, {30, 38}}, 0, 1, 1), first_day_s);
  write_session(dir / "after", drive_b_to_c_driven_on(1), first_day_s + month_s);
  write_session(dir / "carried",
                carried(drive_a_to_c(1), drive(other_mine(), {{2, 0}, {50, 0}}, 0, 4, 1), {400, 0, 0}));
  for (unsigned i = 0; i < 50; ++i) {
    const double x_m = 1 + i;
    write_session(dir / ("short_" + std::to_string(i)),
                  drive(branches_mine(), {{x_m, 0}, {x_m + 6, 0}}, 0.1 * i, 100 + i, 2));
  }
}

}  // namespace
}  // namespace headframe::test

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "usage: headframe-drawn-sessions DIR\n");
    return 2;
  }
  try {
    headframe::test::write_all(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "headframe-drawn-sessions: %s\n", error.what());
    return 1;
  }
}
