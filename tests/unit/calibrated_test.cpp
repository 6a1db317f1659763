// What people are told of a placement that is not convincing.
#include <gtest/gtest.h>

#include <cmath>

#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

double told(double probability, double if_unique, double accept = VerdictThresholds{}.accept_probability) {
  Evidence e;
  e.probability = probability;
  e.probability_if_unique = if_unique;
  VerdictThresholds thresholds;
  thresholds.accept_probability = accept;
  return calibrated(e, thresholds);
}

TEST(Calibrated, WhatOnlyLikenessSpeaksAgainstMayBeRight) {
  const double candidate = VerdictThresholds{}.candidate_probability;
  EXPECT_GT(told(0, 1), 0.3);
  EXPECT_LT(told(0, 1), 0.7);
  EXPECT_GT(told(1e-9, 0.85), candidate);
  EXPECT_LT(told(1e-9, 0.82), candidate);
  EXPECT_LT(told(1e-9, 0.5), 0.02) << "the rock itself speaks against it";
  EXPECT_LT(told(0, 0), 0.01);
}

TEST(Calibrated, NothingConvincesThatDidNot) {
  for (const double accept : {0.3, 0.5, 0.9, 0.99}) {
    EXPECT_LT(told(std::nextafter(accept, 0), 1, accept), accept);
    for (const double p : {accept, (1 + accept) / 2, 1.0}) EXPECT_EQ(told(p, 1, accept), p);
  }
}

TEST(Calibrated, MoreEvidenceNeverLowersIt) {
  constexpr double step = 1e-3;
  for (double p = 0; p < 1; p += step) {
    EXPECT_GE(told(p, p), p);
    EXPECT_LE(told(p, 0.5), told(p + step, 0.5));
    EXPECT_LE(told(p, 0.99), told(p + step, 0.99));
    EXPECT_LE(told(p, 1), told(p + step, 1));
    EXPECT_LE(told(0.1, p), told(0.1, p + step));
    EXPECT_NEAR(told(p, 0.99), told(p + step, 0.99), 0.01) << "no cliff";
    EXPECT_NEAR(told(0, p), told(0, p + step), 0.01) << "no cliff";
  }
}

}  // namespace
}  // namespace headframe
