#include "tests/bench/calibration.hpp"

#include <gtest/gtest.h>

namespace headframe::bench {
namespace {

TEST(Calibration, ProbabilitiesThatComeTrueAreNoError) {
  Calibration c;
  EXPECT_EQ(c.error(), 0);
  for (int i = 0; i < 4; ++i) c.add(0.25, i == 0, "a mine");
  for (int i = 0; i < 20; ++i) c.add(0.95, i > 0, "another");
  EXPECT_NEAR(c.error(), 0, 1e-12);
  EXPECT_EQ(c.json().at("mines"), 2);
  EXPECT_EQ(c.json().at("right"), 20);
}

TEST(Calibration, TheErrorIsTheDistanceOfEachBinWeighedByItsPlacements) {
  Calibration c;
  for (int i = 0; i < 3; ++i) c.add(0.5, true, "m");  // .5 off
  c.add(0.1, false, "m");                             // .1 off
  EXPECT_NEAR(c.error(), (3 * 0.5 + 0.1) / 4, 1e-12);
}

TEST(Calibration, ABinHoldsItsLowerEnd) {
  Calibration c;
  c.add(0.39, true, "m");
  c.add(0.4, false, "m");
  EXPECT_NEAR(c.error(), (0.61 + 0.4) / 2, 1e-12) << "in one bin they would make up for each other";
  Calibration ends;
  ends.add(0, false, "m");
  ends.add(1, true, "m");
  EXPECT_EQ(ends.error(), 0);
}

TEST(Calibration, OnlyWrongOnesThatWouldBeAcceptedAreFalse) {
  Calibration c;
  c.add(0.89, false, "m");
  EXPECT_EQ(c.json().at("false"), 0);
  c.add(0.9, false, "m");
  c.add(0.9, true, "m");
  EXPECT_EQ(c.json().at("false"), 1);
}

TEST(Calibration, APictureThatCanNotBeWrittenIsSaid) {
  EXPECT_EQ(Calibration().draw("/no/such/folder/a.png").error().code, ErrorCode::unavailable);
}

}  // namespace
}  // namespace headframe::bench
