#include <gtest/gtest.h>

#include <cmath>

#include "server/merge/merge_config.hpp"
#include "server/verification/verification.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

using test::convincing;

TEST(Probability, EveryKindOfEvidenceCounts) {
  const auto p = [](const Evidence& e) { return probability(RegistrationStatus::converged, e); };
  const Evidence good = convincing();
  EXPECT_GT(p(good), 0.95);
  const auto with = [&](double Evidence::*member, double value) {
    Evidence e = good;
    e.*member = value;
    return p(e);
  };
  EXPECT_LT(with(&Evidence::worst_place_violation, 0.06), 0.5);
  EXPECT_LT(with(&Evidence::residual_m, 0.12), 0.5);
  EXPECT_LT(with(&Evidence::places_agreeing, 2), 0.9);
  EXPECT_LT(with(&Evidence::rmse_m, 0.25), 0.5);
  EXPECT_EQ(with(&Evidence::rmse_m, 0.12), p(good)) << "a lidar's noise, and dust";
  EXPECT_LT(with(&Evidence::rmse_m, 0.13), p(good));
  EXPECT_LT(with(&Evidence::freespace_violation, 0.03), 0.5);
  EXPECT_LT(with(&Evidence::look_alikes, 2.5), p(good));
  EXPECT_EQ(with(&Evidence::look_alikes, 1), p(good)) << "36 m are told from one";
  EXPECT_LT(with(&Evidence::aliases, 3), 0.5) << "36 m of a mine that repeats itself";
  EXPECT_EQ(with(&Evidence::tilt_deg, 3.1), 0);
  EXPECT_LT(with(&Evidence::overlap_m, 15), p(good));
  EXPECT_LT(with(&Evidence::overlap_m, 3), with(&Evidence::overlap_m, 15));
  EXPECT_EQ(with(&Evidence::overlap_m, 1), with(&Evidence::overlap_m, 0)) << "two lidars that look into one hall";
  EXPECT_EQ(with(&Evidence::tilt_deg, 0.5), p(good)) << "as level as sessions are";
  EXPECT_LT(with(&Evidence::tilt_deg, 1.2), 0.9) << "it leans";
  EXPECT_NEAR(with(&Evidence::tilt_deg, 0.99), with(&Evidence::tilt_deg, 1.01), 0.05) << "no cliff";
  Evidence far = good;
  far.tilt_deg = 1.2;
  far.overlap_m = 55;
  EXPECT_LT(p(far), 0.9);
  far.overlap_m = 75;
  EXPECT_GT(p(far), 0.9) << "odometry drifts out of level";
  EXPECT_LE(probability(RegistrationStatus::degenerate, good), 0.4) << "slides along the drift: at most a candidate";
  EXPECT_EQ(probability(RegistrationStatus::too_little_overlap, good), 0);
  Evidence longer = good;
  longer.aliases = 3;
  longer.overlap_m = 101;
  EXPECT_GT(p(longer), 0.98) << "a longer overlap makes up for copies";
}

TEST(Probability, WherePointsScatterAsWellALittleTiltIsADoubt) {
  const auto p = [](double tilt_deg, double rmse_m, double overlap_m = 31) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.tilt_deg = tilt_deg;
    e.rmse_m = rmse_m;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.498, 0.127), 0.85) << "a copy of rough tunnel";
  EXPECT_EQ(p(0.35, 0.127), p(0, 0.127));
  EXPECT_EQ(p(0.498, 0.11), p(0, 0.11)) << "the surfaces tell";
  EXPECT_EQ(p(0.498, 0.127, 75), p(0, 0.127, 75)) << "odometry drifts out of level";
  for (double tilt_deg = 0.3; tilt_deg < 1; tilt_deg += 0.005)
    EXPECT_NEAR(p(tilt_deg, 0.127), p(tilt_deg + 0.005, 0.127), 0.05);
}

TEST(Probability, ALongOverlapOnWhichAllAgreeCounts) {
  const auto p = [](double overlap_m, double agreeing = 6, double hold = 0.1) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.places_agreeing = agreeing;
    e.weakest_hold = hold;
    e.end_on_match = 1;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(36), p(42));
  EXPECT_EQ(p(43), p(60));
  EXPECT_LT(p(60), p(90));
  EXPECT_LT(p(90), p(120));
  EXPECT_EQ(p(120), p(500));
  EXPECT_EQ(p(60, 5), p(120, 5)) << "a place disagrees";
  EXPECT_EQ(p(60, 6, held_well - 0.001), p(120, 6, held_well - 0.001)) << "a smooth drift is long for nothing";
}

TEST(Probability, WhatIsContradictedFartherOffIsBelievedLess) {
  Judgement j{RegistrationStatus::converged, Pose::Identity(), convincing()};
  const auto p = [&](double farther) {
    j.evidence.farther_violation = farther;
    weigh(j);
    return j.evidence.probability;
  };
  EXPECT_EQ(p(0.0018), p(0));
  EXPECT_LT(p(0.0027), p(0) - 0.05) << "drift excuses little over a short overlap";
  j.evidence.overlap_m = 60;
  const double believed = p(0);
  EXPECT_EQ(p(0.002), believed);
  const double contradicted_farther = 0.003;
  EXPECT_LT(p(contradicted_farther), believed);
  EXPECT_NEAR(p(0.99 * contradicted_farther), p(1.01 * contradicted_farther), 0.05) << "no cliff";
  EXPECT_LT(p(0.03), MergeConfig{}.accept_probability);
  EXPECT_LT(j.evidence.probability_if_unique, MergeConfig{}.accept_probability);
}

TEST(Probability, WhereSurfacesLieApartLittleFartherOffIsADoubt) {
  const auto p = [](double residual_m, double farther, double overlap_m = 45) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.residual_m = residual_m;
    e.farther_violation = farther;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.067, 0.0013), 0.5) << "two ramps of different mines";
  EXPECT_EQ(p(0.067, 0.0003), p(0.067, 0));
  EXPECT_EQ(p(0.05, 0.0013), p(0.05, 0)) << "the surfaces tell";
  EXPECT_EQ(p(0.067, 0.0013, 75), p(0.067, 0, 75)) << "the overlap tells";
  for (double farther = 0; farther < 0.003; farther += 1e-5)
    EXPECT_NEAR(p(0.067, farther), p(0.067, farther + 1e-5), 0.05);
}

TEST(Probability, FewPointsThatMeetSpeakAgainst) {
  const auto p = [](double inliers) {
    Evidence e = convincing();
    e.inlier_fraction = inliers;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_EQ(p(0.3), p(0.9));
  EXPECT_LT(p(0.29), p(0.3));
  EXPECT_GT(p(0.28), MergeConfig{}.accept_probability) << "right ones of a cave and a surveyed mine";
  EXPECT_LT(p(0.14), 0.5) << "side by side, with rock between them";
}

TEST(Probability, OfFewPlacesMostOfWhatBothCouldSeeHasToMatch) {
  const auto p = [](double places, double matched) {
    Evidence e = convincing();
    e.places = e.places_agreeing = places;
    e.overlap_m = 12;
    e.residual_m = 0.05;
    e.rmse_m = 0.121;
    e.matched_share = matched;
    return probability(RegistrationStatus::converged, e);
  };
  const double right = 0.745, wrong = 0.6;
  EXPECT_GT(p(3, right), MergeConfig{}.accept_probability);
  EXPECT_NEAR(std::log(p(3, right) / (1 - p(3, right))) - std::log(p(3, wrong) / (1 - p(3, wrong))), 1.44, 1e-6)
      << "14 m off in a surveyed mine, and all else agreed";
  EXPECT_EQ(p(3, 0.72), p(3, 1));
  EXPECT_LT(p(3, 0.71), p(3, 0.72));
  EXPECT_LT(p(3, wrong), p(4, wrong));
  EXPECT_EQ(p(5, 0.52), p(5, 1)) << "five places in a surveyed mine were right";
}

double over(double overlap_m, double Evidence::*member, double value) {
  Evidence e = convincing();
  e.overlap_m = overlap_m;
  e.*member = value;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, WhereHardlyAnyPathIsSharedMostOfWhatBothCouldSeeHasToMatch) {
  const auto p = [](double overlap_m, double matched) { return over(overlap_m, &Evidence::matched_share, matched); };
  EXPECT_GT(p(8, 0.69), MergeConfig{}.accept_probability) << "a surveyed mine";
  EXPECT_LT(p(5.3, 0.683), MergeConfig{}.accept_probability) << "112 m off, in a cave";
  EXPECT_LT(p(6.4, 0.604), 0.7) << "another";
  EXPECT_EQ(p(8, 0.74), p(8, 1));
  EXPECT_EQ(p(10, 0.6), p(10, 1));
  EXPECT_LT(p(9, 0.6), p(10, 0.6));
}

TEST(Probability, WhereHardlyAnyPathIsSharedMorePointsHaveToMeet) {
  const auto p = [](double overlap_m, double inliers) { return over(overlap_m, &Evidence::inlier_fraction, inliers); };
  EXPECT_EQ(p(8, 0.4), p(8, 0.9));
  EXPECT_LT(p(8, 0.39), p(8, 0.4));
  EXPECT_LT(p(7.6, 0.28), MergeConfig{}.accept_probability) << "elsewhere in a surveyed mine";
  EXPECT_EQ(p(10, 0.3), p(10, 0.9));
}

TEST(Probability, WhereHardlyAnyPathIsSharedTheWallsHaveToHold) {
  const auto p = [](double overlap_m, double hold) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.places = e.places_agreeing = 2;
    e.weakest_hold = hold;
    e.end_on_match = 0.4;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_GT(p(5, 0.05), MergeConfig{}.accept_probability);
  EXPECT_LT(p(2.3, 0.03), p(2.3, 0.052)) << "a piece of a tunnel elsewhere";
  EXPECT_EQ(p(2.3, 0.052), p(2.3, 0.2));
  EXPECT_EQ(p(10, 0.03), p(10, 0.2));
}

TEST(Probability, PlacesThatSlidMetresApartSpeakAgainst) {
  const auto p = [](double overlap_m, double spread_m) { return over(overlap_m, &Evidence::spread_m, spread_m); };
  EXPECT_EQ(p(65, 0.97), p(65, 0)) << "drift";
  EXPECT_EQ(p(16, 1.3), p(16, 0));
  EXPECT_LT(p(16, 1.4), p(16, 1.3));
  EXPECT_LT(p(5.5, 2.25), 0.7) << "2 m off along a tunnel";
  EXPECT_EQ(p(200, 3), p(200, 0)) << "the drift of a long way together";
}

TEST(Probability, DescriptorsThatAreUnlikeAlongThePathSpeakAgainst) {
  const auto p = [](double compared, double alike) {
    Evidence e = convincing();
    e.descriptors_compared = compared;
    e.descriptors_alike = alike;
    return probability(RegistrationStatus::converged, e);
  };
  const double asked = asked_alike(convincing());
  EXPECT_EQ(p(0, 0), p(0, 1)) << "nothing compared, nothing said";
  EXPECT_LE(p(12, asked), p(12, 1));
  EXPECT_LT(p(12, asked - 0.01), p(12, asked));
  EXPECT_LT(p(12, 0.5), 0.9);
  EXPECT_GT(p(2, 0.5), p(12, 0.5)) << "two keyframes are few";
  EXPECT_EQ(p(10, 0.5), p(100, 0.5)) << "ten say it all";
}

TEST(Probability, AtACrossingWhereNothingLooksAlikeDescriptorsSayLittle) {
  const auto p = [](double compared, double look_alikes) {
    Evidence e = convincing();
    e.overlap_m = 12;
    e.descriptors_compared = compared;
    e.look_alikes = look_alikes;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_GT(p(2, 0), 0.9) << "a surveyed mine: 12 m, both looked another way";
  EXPECT_LT(p(2, 2.5), 0.9) << "among look-alikes it may be a copy";
  EXPECT_LT(p(8, 0), 0.5) << "eight are many";
  EXPECT_GT(p(3, 0), p(4, 0));
}

TEST(Probability, WhereADriftHardlyHoldsItsEndsHaveToMeet) {
  const auto p = [](double hold, double end_on_match, double violation) {
    Evidence e = convincing();
    e.weakest_hold = hold;
    e.end_on_match = end_on_match;
    e.worst_place_violation = violation;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_EQ(p(held_well, 0, 0), p(0.1, 0, 0)) << "what holds needs no ends";
  EXPECT_LT(p(0.9 * held_well, 0, 0), 0.8);
  EXPECT_NEAR(p(0.9 * held_well, ends_meet, 0), p(0.1, 0, 0), 1e-4);
  EXPECT_LT(p(0.9 * held_well, 0.9 * ends_meet, 0), p(0.1, 0, 0) - 1e-4);
}

TEST(Probability, APieceOfTunnelThatTheWallsHoldLooselyDoesNotSuffice) {
  const auto p = [](double hold, double overlap_m) {
    Evidence e = convincing();
    e.weakest_hold = hold;
    e.overlap_m = overlap_m;
    e.matched_share = 0.9;
    e.places = e.places_agreeing = 3;
    e.look_alikes = 0.4;
    e.descriptors_compared = e.descriptors_alike = 0;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.043, 7.5), 0.9) << "a piece of tunnel that is not the place";
  EXPECT_GT(p(0.0525, 4.7), 0.9);
  EXPECT_NEAR(p(0.048, 7.5), p(0.0481, 7.5), 0.01) << "no cliff";
  EXPECT_EQ(p(0.043, 10), p(0.2, 10));
}

}  // namespace
}  // namespace headframe
