// What a placement has to show if the two sessions' descriptors cannot be compared: those of two families, or of a
// family whose similarity was never measured.

#include <gtest/gtest.h>

#include "server/merge/merge_config.hpp"
#include "server/verification/verdict.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

const double accepted = MergeConfig{}.accept_probability;

/// Look-alikes, shared path, hold by the walls, and how many of six places disagree.
double p(double look_alikes, double overlap_m, double hold, double disagreeing = 0, double compared = 0) {
  Evidence e = test::convincing();
  e.look_alikes = look_alikes;
  e.overlap_m = overlap_m;
  e.weakest_hold = hold;
  e.places_agreeing = e.places - disagreeing;
  e.descriptors_compared = compared;
  e.descriptors_alike = compared > 0 ? 0.95 : 0;
  return probability(RegistrationStatus::converged, e);
}

TEST(ProbabilityWithoutDescriptors, CopiesThatTheWallsHoldLooselyAreNotBelieved) {
  EXPECT_LT(p(0.65, 17.4, 0.051), accepted);
  EXPECT_LT(p(0.75, 22.5, 0.038), accepted);
  EXPECT_LT(p(3.4, 30.6, 0.031), accepted);
  EXPECT_LT(p(2.6, 49.9, 0.059), accepted);
  EXPECT_LT(p(7.4, 51.1, 0.052), accepted);
}

TEST(ProbabilityWithoutDescriptors, WhatNothingResemblesNeedsNoMoreThanBefore) {
  for (const double hold : {0.04, 0.1}) {
    EXPECT_GT(p(0, 15, hold), accepted);
    EXPECT_EQ(p(0, 15, hold), p(0, 15, 0.2));
    EXPECT_GT(p(0.4, 15, hold), accepted) << "as in a cave";
  }
}

TEST(ProbabilityWithoutDescriptors, WhatTheWallsHoldFirmlyNeedsLess) {
  EXPECT_LT(p(1, 40, 0.06), accepted);
  EXPECT_GT(p(1, 40, held_firmly), accepted);
  EXPECT_EQ(p(1, 40, held_firmly), p(1, 40, 0.2));
  EXPECT_EQ(p(1, 40, 0.06), p(1, 40, 0.045)) << "loosely is loosely";
  EXPECT_LT(p(1, 18, 0.08), accepted) << "short even so";
  EXPECT_GT(p(1, 14, 0.11), accepted) << "copies of a tile were held more loosely";
  EXPECT_LT(p(1.8, 14, 0.11), accepted) << "a mine that looks like itself";
  EXPECT_GT(p(1, 28, 0.1), accepted);
}

TEST(ProbabilityWithoutDescriptors, SixtyMetresAreEnough) {
  EXPECT_GT(p(1, 60, 0.05), accepted);
  EXPECT_LT(p(1, 45, 0.05), accepted);
  EXPECT_LT(p(1, 45, 0.05), p(1, 50, 0.05));
}

TEST(ProbabilityWithoutDescriptors, APlaceThatDisagreesIsADoubtWhereTheWallsHoldLoosely) {
  const double not_compared = p(0, 28, 0.055, 1);
  EXPECT_LT(not_compared, 0.3) << "a copy at which nothing looked alike";
  EXPECT_GT(p(0, 28, 0.055, 1, 10), not_compared + 0.5) << "descriptors tell";
  EXPECT_GT(p(0, 28, 0.1, 1), not_compared + 0.5) << "so do walls";
  EXPECT_GT(p(0, 60, 0.055, 1), not_compared + 0.5);
}

TEST(ProbabilityWithoutDescriptors, AmongThreeLookAlikesMorePathIsAskedFor) {
  EXPECT_LT(p(3.2, 57.6, 0.062), accepted) << "a copy";
  EXPECT_GT(p(3.2, 75, 0.062), accepted);
  EXPECT_GT(p(2, 60, 0.055), accepted);
  EXPECT_GT(p(3.2, 57.6, 0.08), accepted) << "walls that hold it tell";
  EXPECT_GT(p(3.2, 57.6, 0.062, 0, 8), accepted) << "descriptors tell";
}

/// A short overlap, for which all else speaks.
struct Short {
  double support, rmse_m, overlap_m, compared = 0, alike = 0;
};

double p_of_short(const Short& shown) {
  Evidence e = test::convincing();
  e.support = shown.support;
  e.rmse_m = shown.rmse_m;
  e.overlap_m = shown.overlap_m;
  e.weakest_hold = 0.2;
  e.inlier_fraction = 0.4;
  e.descriptors_compared = shown.compared;
  e.descriptors_alike = shown.alike;
  return probability(RegistrationStatus::converged, e);
}

TEST(ProbabilityWithFewDescriptors, CopiesOfATileOrTwoAreNotBelieved) {
  EXPECT_LT(p_of_short({101, 0.119, 15}), accepted) << "cave";
  EXPECT_LT(p_of_short({86, 0.089, 13}), accepted) << "cave of few kinds";
  EXPECT_LT(p_of_short({137, 0.11, 13}), accepted) << "mixed tunnels";
  EXPECT_LT(p_of_short({111, 0.1, 13, 1, 0.86}), accepted) << "rough tunnel";
  EXPECT_LT(p_of_short({135, 0.144, 18, 4, 0.88}), accepted);
  EXPECT_LT(p_of_short({118, 0.088, 24, 3, 0.7}), accepted) << "cave, descriptors that hardly agree";
  EXPECT_LT(p_of_short({178, 0.096, 20, 3, 0.3}), accepted) << "rough tunnel, descriptors that differ";
  EXPECT_LT(p_of_short({-75, 0.072, 19, 2, 0.83}), accepted) << "walls farther off contradict";
}

TEST(ProbabilityWithFewDescriptors, WallsSurfacesAndDescriptorsTellAShortOverlapFromACopy) {
  EXPECT_GT(p_of_short({200, 0.11, 13}), accepted);
  EXPECT_GT(p_of_short({137, 0.08, 13}), accepted);
  EXPECT_GT(p_of_short({118, 0.088, 24, 3, 0.9}), accepted);
  EXPECT_GT(p_of_short({118, 0.088, 13}), p_of_short({118, 0.088, 20})) << "more is asked of more path";
  EXPECT_EQ(p_of_short({200, 0.11, 13}), p_of_short({400, 0.11, 13})) << "200 cells tell all";
}

TEST(ProbabilityWithFewDescriptors, ALongerOverlapMoreDescriptorsAndWallsThatWereNotComparedAskForNoMore) {
  EXPECT_LT(p_of_short({90, 0.1, 36}), accepted);
  EXPECT_GT(p_of_short({90, 0.1, 44}), accepted);
  EXPECT_LT(p_of_short({90, 0.1, 22, 5, 0.7}), accepted);
  EXPECT_LT(p_of_short({90, 0.1, 22, 8, 0.7}), accepted);
  EXPECT_GT(p_of_short({90, 0.1, 22, 12, 0.85}), accepted);
  EXPECT_GT(p_of_short({0, 0.1, 20}), accepted);
}

TEST(ProbabilityWithFewDescriptors, SeveralThatDifferAreADoubtThoughNothingLooksAlike) {
  EXPECT_LT(p_of_short({300, 0.083, 40, 9, 0.716}), accepted - 0.3) << "a copy of a cave, driven through live";
  EXPECT_LT(p_of_short({300, 0.077, 34, 5, 0.663}), accepted - 0.3);
  EXPECT_GT(p_of_short({300, 0.083, 40, 9, 0.76}), accepted);
  EXPECT_GT(p_of_short({300, 0.083, 50, 9, 0.716}), accepted) << "the overlap tells";
  EXPECT_GT(p_of_short({300, 0.083, 40, 3, 0.716}), accepted) << "three are few";
}

TEST(ProbabilityWithFewDescriptors, NothingJumps) {
  for (double cells = 60; cells < 210; ++cells)
    EXPECT_NEAR(p_of_short({cells, 0.1, 13}), p_of_short({cells + 1, 0.1, 13}), 0.05);
  for (double rmse_m = 0.06; rmse_m < 0.13; rmse_m += 5e-4)
    EXPECT_NEAR(p_of_short({130, rmse_m, 13}), p_of_short({130, rmse_m + 5e-4, 13}), 0.05);
  for (double metres = 4; metres < 46; metres += 0.2)
    EXPECT_NEAR(p_of_short({110, 0.1, metres}), p_of_short({110, 0.1, metres + 0.2}), 0.05);
  for (double alike = 0.6; alike < 0.95; alike += 0.004)
    EXPECT_NEAR(p_of_short({118, 0.088, 24, 3, alike}), p_of_short({118, 0.088, 24, 3, alike + 0.004}), 0.05);
}

TEST(ProbabilityWithoutDescriptors, APlaceThatIsContradictedALittleIsADoubt) {
  const auto p = [](double violation, double overlap_m = 15.5, double compared = 0) {
    Evidence e = test::convincing();
    e.support = 238;
    e.overlap_m = overlap_m;
    e.worst_place_violation = violation;
    e.descriptors_compared = compared;
    e.descriptors_alike = 0.85;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.00135), accepted - 0.1) << "a copy of rough tunnel";
  EXPECT_GT(p(0.0003), accepted);
  EXPECT_GT(p(0.00135, 36), accepted) << "the overlap tells";
  EXPECT_GT(p(0.00135, 15.5, 2), accepted) << "left to the descriptors";
  for (double violation = 0.0002; violation < 0.002; violation += 2e-5)
    EXPECT_NEAR(p(violation), p(violation + 2e-5), 0.05);
}

TEST(ProbabilityWithoutDescriptors, PlacesThatLieApartOverAFewMetresAreADoubtUnlessTheWallsHoldFirmly) {
  const auto p = [](double spread_m, double hold, double overlap_m = 5.9, double compared = 0) {
    Evidence e = test::convincing();
    e.places = e.places_agreeing = 3;
    e.overlap_m = overlap_m;
    e.spread_m = spread_m;
    e.weakest_hold = hold;
    e.descriptors_compared = compared;
    e.descriptors_alike = 0.95;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.24, 0.071), accepted - 0.1) << "the copy of a tunnel's piece";
  EXPECT_EQ(p(0.24, 0.071), p(0.2, 0.08));
  EXPECT_EQ(p(0.1, 0.071), p(0, 0.071));
  EXPECT_GT(p(0.1, 0.071), accepted);
  EXPECT_EQ(p(0.2, 0.11), p(0.1, 0.11)) << "as between paths that only cross";
  EXPECT_EQ(p(0.24, 0.071, 15), p(0.1, 0.071, 15)) << "a longer overlap tells by itself";
  EXPECT_GT(p(0.24, 0.071, 5.9, 2), accepted) << "the descriptors decide";
  for (double spread_m = 0.1; spread_m < 0.2; spread_m += 0.001)
    EXPECT_NEAR(p(spread_m, 0.071), p(spread_m + 0.001, 0.071), 0.05) << "no cliff";
}

TEST(ProbabilityWithoutDescriptors, ComparedDescriptorsLiftTheDemand) {
  EXPECT_LT(p(1, 40, 0.055), accepted);
  EXPECT_GT(p(1, 40, 0.055, 0, 8), accepted);
}

}  // namespace
}  // namespace headframe
