// What is seen farther off: rock that both saw, as far as clouds show it.

#include <gtest/gtest.h>

#include "tests/scenario/drawn_base.hpp"
#include "tests/scenario/drawn_copies.hpp"

namespace headframe {
namespace {

using test::along_copies;
using test::Base;
using test::Drive;

/// Of two drives; of the first, every so many clouds are lost (0: none).
Evidence evidence(Drive first, Drive second, std::size_t every_lost = 0) {
  Base base({std::move(first), std::move(second)});
  for (std::size_t k = every_lost; every_lost > 0 && k <= base.drive(1).clouds.size(); k += every_lost)
    base.shelf.clouds.erase({1, k});
  base.pipeline.attempt(1, base.shelf);
  return base.pipeline.alignments().front().evidence;
}

double rock_in_common(Drive first, Drive second) {
  return evidence(std::move(first), std::move(second)).rock_in_common;
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

/// What no cloud shows may be open ground, through which rays may pass; what both clouds show is rock.
TEST(LongRange, WhereCloudsAreMissingRockCountsAndNothingContradicts) {
  const Drive ends = along_copies(94, 0, 5, 8), goes_on = along_copies(110, 1.1, 6, 8);
  const Evidence all = evidence(ends, goes_on), lacking = evidence(ends, goes_on, 6);
  EXPECT_GT(all.farther_violation, 0.002) << "one of the mines ends";
  EXPECT_EQ(lacking.farther_violation, 0);
  EXPECT_GT(lacking.rock_in_common, 0.5 * all.rock_in_common);
  EXPECT_LT(lacking.rock_in_common, 1.1 * all.rock_in_common);
}

}  // namespace
}  // namespace headframe
