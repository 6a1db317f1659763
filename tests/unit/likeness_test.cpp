#include <gtest/gtest.h>

#include "server/verification/screening_result.hpp"

namespace headframe {
namespace {

/// A place of 10 000 points, the 100 included that always count as agreeing, that fits as an exact copy does.
ScreeningResult exact_copy() {
  ScreeningResult r;
  r.hopeful = true;
  r.place.matched = {460, 460};
  r.place.residual_m = 0.03;
  r.place.a_by_b = {.seen = 9900, .violated = 0, .lone = 0, .unknown = 0};
  r.place.registration.status = RegistrationStatus::converged;
  r.place.registration.direction_hold[0] = 0.1;
  return r;
}

ScreeningResult contradicted(double points) {
  ScreeningResult r = exact_copy();
  r.place.a_by_b.seen -= points;
  r.place.a_by_b.violated = points;
  return r;
}

TEST(Likeness, OnlyWhatNextToNothingContradictsIsACopy) {
  EXPECT_EQ(likeness(exact_copy()), 1);
  EXPECT_EQ(likeness(contradicted(10)), 1);
  EXPECT_NEAR(likeness(contradicted(25)), 0.5, 1e-9);
  EXPECT_EQ(likeness(contradicted(40)), 0);
  EXPECT_TRUE(fits_alone(contradicted(19)));
  EXPECT_FALSE(fits_alone(contradicted(20))) << "another piece of a surveyed mine";
}

TEST(Likeness, WhatIsContradictedMoreIsSimilarAllTheSame) {
  EXPECT_EQ(resemblance(exact_copy()), 1);
  EXPECT_EQ(resemblance(contradicted(5)), 1);
  EXPECT_NEAR(resemblance(contradicted(62.5)), 0.5, 1e-9);
  EXPECT_EQ(resemblance(contradicted(120)), 0);
}

TEST(Likeness, ACopyMatchesWithSurfacesThatCoincideAndCannotSlide) {
  const auto with = [](auto change) {
    ScreeningResult r = exact_copy();
    change(r);
    return r;
  };
  const auto unmatched = with([](ScreeningResult& r) { r.place.matched = {325, 460}; });
  EXPECT_EQ(likeness(unmatched), 0) << "65 % of the points and 40 more";
  EXPECT_FALSE(fits_alone(unmatched));
  const auto apart = with([](ScreeningResult& r) { r.place.residual_m = 0.065; });
  EXPECT_NEAR(likeness(apart), 0, 1e-9);
  EXPECT_FALSE(fits_alone(apart));
  const auto half = with([](ScreeningResult& r) { r.place.registration.direction_hold[0] = 0.025; });
  EXPECT_NEAR(likeness(half), 0.5, 1e-9);
  EXPECT_FALSE(fits_alone(half));
  EXPECT_FALSE(
      fits_alone(with([](ScreeningResult& r) { r.place.registration.status = RegistrationStatus::not_converged; })));
  const auto given_up = with([](ScreeningResult& r) { r.hopeful = false; });
  EXPECT_EQ(likeness(given_up), 0);
  EXPECT_FALSE(fits_alone(given_up));
}

}  // namespace
}  // namespace headframe
