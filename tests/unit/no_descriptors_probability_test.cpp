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

struct Walls {
  double support, rmse_m, hold, overlap_m, compared, alike = 0.8;
};

double p_of_walls(const Walls& walls) {
  Evidence e = test::convincing();
  e.support = walls.support;
  e.rmse_m = walls.rmse_m;
  e.weakest_hold = walls.hold;
  e.overlap_m = walls.overlap_m;
  e.inlier_fraction = 0.4;
  e.descriptors_compared = walls.compared;
  e.descriptors_alike = walls.alike;
  return probability(RegistrationStatus::converged, e);
}

TEST(ProbabilityWithoutDescriptors, WallsFartherOffHaveToMatchWherePointsScatterAndTheWallsHoldItFromTwoSidesOnly) {
  const auto p = [](double support, double rmse_m, double hold, double overlap_m = 17.7, double compared = 0) {
    return p_of_walls({support, rmse_m, hold, overlap_m, compared});
  };
  EXPECT_LT(p(110, 0.107, 0.093), 0.85) << "a copy of a tile of rough tunnel";
  EXPECT_LT(p(108, 0.12, 0.076), 0.85) << "a copy of a tile of cave";
  EXPECT_LT(p(129, 0.135, 0.0735, 8.7), 0.85) << "one of two tiles that meet";
  EXPECT_GT(p(145, 0.107, 0.093), accepted) << "the walls tell";
  EXPECT_GT(p(110, 0.095, 0.093), accepted) << "the surfaces tell";
  EXPECT_GT(p(110, 0.107, 0.16), accepted) << "held from all sides";
  EXPECT_GT(p(110, 0.107, 0.093, 26), accepted) << "the overlap tells";
  EXPECT_GT(p(110, 0.107, 0.093, 17.7, 6), accepted) << "left to the descriptors";
  EXPECT_LT(p(122, 0.079, 0.102, 13), accepted) << "a copy of half a tile, though its surfaces match";
  EXPECT_GT(p(150, 0.079, 0.102, 13), accepted);
  EXPECT_LT(p(137, 0.11, 0.0787, 13), 0.85) << "a copy of mixed tunnels, whose points scatter";
  EXPECT_GT(p(170, 0.11, 0.0787, 13), accepted);
  EXPECT_GT(p(122, 0.079, 0.13, 13), accepted);
  EXPECT_LT(p(96, 0.072, 0.156, 8.7), accepted) << "another, held better, but by walls near the paths only";
  EXPECT_GT(p(96, 0.072, 0.18, 8.7), accepted);
  EXPECT_GT(p(122, 0.079, 0.102, 16), accepted);
  for (double cells = 80; cells < 160; ++cells)
    EXPECT_NEAR(p(cells, 0.079, 0.102, 10), p(cells + 1, 0.079, 0.102, 10), 0.05);
  EXPECT_EQ(p(0, 0.107, 0.093), p(175, 0.107, 0.05)) << "not from the wall search: nothing is known of them";
  for (double cells = 110; cells < 150; cells += 0.2)
    EXPECT_NEAR(p(cells, 0.107, 0.09), p(cells + 0.2, 0.107, 0.09), 0.05);
}

TEST(ProbabilityWithoutDescriptors, WallsThatMatchPoorlyAreADoubtHoweverFirmlyTheyHold) {
  const auto p = [](double support, double rmse_m = 0.103, double overlap_m = 13.2, double compared = 0) {
    return p_of_walls({support, rmse_m, 0.2, overlap_m, compared});
  };
  EXPECT_LT(p(93), 0.85) << "a copy of two tiles of cave";
  EXPECT_LT(p(100, 0.092, 20), accepted);
  EXPECT_EQ(p(100), p(1));
  EXPECT_GT(p(135), accepted) << "the walls tell";
  EXPECT_GT(p(93, 0.08), accepted) << "the surfaces tell";
  EXPECT_GT(p(93, 0.103, 26), accepted) << "the overlap tells";
  EXPECT_GT(p(93, 0.103, 13.2, 2), accepted) << "left to the descriptors";
  for (double cells = 90; cells < 160; ++cells) EXPECT_NEAR(p(cells), p(cells + 1), 0.05);
}

TEST(ProbabilityWithoutDescriptors, WithFewTheWallsFartherOffHaveToMatchWherePointsScatter) {
  const auto p = [](double support, double rmse_m = 0.117, double overlap_m = 17.7, double compared = 4) {
    return p_of_walls({support, rmse_m, 0.2, overlap_m, compared, 0.88});
  };
  EXPECT_LT(p(135), accepted - 0.02) << "a copy of rough tunnel, were it as convincing as this";
  EXPECT_LT(p(140), accepted);
  EXPECT_GT(p(175), accepted) << "the walls tell";
  EXPECT_GT(p(135, 0.1), accepted) << "the surfaces tell";
  EXPECT_GT(p(135, 0.117, 26), accepted) << "the overlap tells";
  EXPECT_GT(p(135, 0.117, 17.7, 6), accepted) << "the descriptors tell";
  for (double cells = 130; cells < 180; ++cells) EXPECT_NEAR(p(cells), p(cells + 1), 0.05);
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
