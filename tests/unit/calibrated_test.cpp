// What people are told of a placement that is not convincing.
#include <gtest/gtest.h>

#include <cmath>

#include "server/verification/verdict.hpp"
#include "server/verification/verdict_curves.hpp"

namespace headframe {
namespace {

double told(double probability, double accept = VerdictThresholds{}.accept_probability) {
  Evidence e;
  e.probability = probability;
  VerdictThresholds thresholds;
  thresholds.accept_probability = accept;
  return calibrated(e, thresholds);
}

TEST(Calibrated, ToldAreTheOddsWithoutTheWeightOfWrongOnes) {
  EXPECT_EQ(told(0), 0);
  for (const double p : {0.01, 0.1, 0.5})
    EXPECT_NEAR(odds(told(p)), verdict_wrong_weight * odds(p), 1e-9 + 1e-9 * odds(p));
}

TEST(Calibrated, NothingConvincesThatDidNot) {
  for (const double accept : {0.3, 0.5, 0.9, 0.99}) {
    EXPECT_LT(told(std::nextafter(accept, 0), accept), accept);
    for (const double p : {accept, (1 + accept) / 2, 1.0}) EXPECT_EQ(told(p, accept), p);
  }
}

TEST(Calibrated, MoreEvidenceNeverLowersIt) {
  constexpr double step = 1e-3;
  for (double p = 0; p + step < 1; p += step) {
    EXPECT_GE(told(p), 0.999 * p);
    EXPECT_LE(told(p), told(p + step));
    EXPECT_NEAR(told(p), told(p + step), 0.01) << "no cliff";
  }
}

}  // namespace
}  // namespace headframe
