// What is seen farther off: rock that both saw, as far as clouds show it.

#include <gtest/gtest.h>

#include "tests/scenario/drawn_base.hpp"
#include "tests/scenario/drawn_copies.hpp"

namespace headframe {
namespace {

using test::along_copies;
using test::Base;
using test::Drive;

double rock_in_common(Drive first, Drive second) {
  Base base({std::move(first), std::move(second)});
  base.pipeline.attempt(1, base.shelf);
  return base.pipeline.alignments().front().evidence.rock_in_common;
}

TEST(LongRange, TheRockThatBothSawIsCountedWhicheverCameFirst) {
  const Drive a = along_copies(99, 0, 5), b = along_copies(99, 1.1, 6);
  const double cubes = rock_in_common(a, b);
  // Floor, roof and walls of 88 m of drift and of four branches are some 2000 square metres; a surface that lies across
  // the cubes fills up to twice as many.
  EXPECT_GT(cubes, 1000);
  EXPECT_LT(cubes, 4000);
  EXPECT_NEAR(rock_in_common(b, a), cubes, 0.05 * cubes);
}

TEST(LongRange, AWideDriftShowsMoreRockOverTheSamePath) {
  const auto in_drift = [](double width_m) {
    return rock_in_common(along_copies(99, 0, 5, width_m), along_copies(99, 1.1, 6, width_m));
  };
  EXPECT_GT(in_drift(8), 1.3 * in_drift(4));
}

}  // namespace
}  // namespace headframe
