// What walls far from the paths tell where hardly any path is shared.

#include <gtest/gtest.h>

#include "server/verification/verdict.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

/// Hardly any path is shared, at so many places.
Evidence hardly_shared(double overlap_m, double places, double matched_share, double inlier_fraction, double hold) {
  Evidence e = test::convincing();
  e.overlap_m = overlap_m;
  e.places = e.places_agreeing = places;
  e.matched_share = matched_share;
  e.inlier_fraction = inlier_fraction;
  e.weakest_hold = hold;
  return e;
}

/// Two robots that look into one hall, held from all sides, whose surfaces match as far as corners let both see them.
Evidence one_hall() { return hardly_shared(7.6, 3, 0.64, 0.54, 0.18); }

double p(const Evidence& e) { return probability(RegistrationStatus::converged, e); }

double with_score(Evidence e, double score) {
  e.support = score;
  return p(e);
}

TEST(ProbabilityOfFarWalls, WallsThatMatchMakeUpForAShortOverlap) {
  EXPECT_LT(p(one_hall()), 0.9);
  EXPECT_EQ(with_score(one_hall(), 100), p(one_hall()));
  EXPECT_GT(with_score(one_hall(), 139), 0.95);
  EXPECT_EQ(with_score(one_hall(), 150), with_score(one_hall(), 1000));
  for (double score = 90; score < 160; ++score)
    EXPECT_NEAR(with_score(one_hall(), score), with_score(one_hall(), score + 1), 0.05) << "no cliff";
}

TEST(ProbabilityOfFarWalls, TheyAddNothingToALongOverlapAndExcuseNoContradiction) {
  const Evidence overlap = test::convincing();
  EXPECT_EQ(with_score(overlap, 1000), p(overlap));
  Evidence contradicted = one_hall();
  contradicted.freespace_violation = contradicted.worst_place_violation = 0.01;
  EXPECT_LT(with_score(contradicted, 1000), 0.5);
}

/// Two robots in tunnels that pass each other and see into one another through a gap; the copy of such a gap that was
/// merged wrongly scored 90.
TEST(ProbabilityOfFarWalls, ALowScoreIsADoubtWhereHardlyAnyPathIsShared) {
  Evidence gap = hardly_shared(6.3, 6, 0.72, 0.39, 0.18);
  EXPECT_GT(with_score(gap, 100), 0.9);
  EXPECT_LT(with_score(gap, 90), 0.9);
  EXPECT_EQ(with_score(gap, 90), with_score(gap, 60));
  EXPECT_EQ(with_score(gap, 100), with_score(gap, 0)) << "0: no walls were compared";
  gap.overlap_m = 10;
  EXPECT_EQ(with_score(gap, 100), with_score(gap, 90));
}

/// Two places of a cave, 193 m apart, that fitted over 5 m and were merged, scored 114; right ones 149 and more.
TEST(ProbabilityOfFarWalls, TwoPlacesOfHardlyAnyPathNeedWallsFartherOff) {
  Evidence two = hardly_shared(5.4, 2, 0.75, 0.46, 0.114);
  EXPECT_LT(with_score(two, 114), 0.9);
  EXPECT_GT(with_score(two, 149), 0.9);
  for (double score = 90; score < 160; ++score)
    EXPECT_NEAR(with_score(two, score), with_score(two, score + 1), 0.05) << "no cliff";
  two.places = two.places_agreeing = 3;
  EXPECT_GT(with_score(two, 114), 0.9);
}

TEST(ProbabilityOfFarWalls, AlongATunnelThatHoldsLooselyTheyTellNothing) {
  const auto more = [](double hold) {
    Evidence e = one_hall();
    e.weakest_hold = hold;
    return with_score(e, 150) - p(e);
  };
  EXPECT_EQ(more(0.05), 0);
  EXPECT_GT(more(0.08), 0.1);
}

TEST(ProbabilityOfFarWalls, TheyTellNothingWherePlacesLookAlike) {
  const auto alike = [](double Evidence::*member, double value) {
    Evidence e = one_hall();
    e.*member = value;
    return with_score(e, 150) - p(e);
  };
  EXPECT_GT(alike(&Evidence::look_alikes, 0.25), 0.1);
  EXPECT_EQ(alike(&Evidence::look_alikes, 0.75), 0);
  EXPECT_GT(alike(&Evidence::mine_look_alikes, 0.1), 0.1);
  EXPECT_EQ(alike(&Evidence::mine_look_alikes, 0.3), 0);
  EXPECT_EQ(alike(&Evidence::aliases, 1), 0);
}

}  // namespace
}  // namespace headframe
