// Copies in mines of equal tunnels, and what gives them away.

#include <gtest/gtest.h>

#include "server/verification/verdict.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

using test::convincing;

/// Figures of a copy in a mine of equal tunnels, and how far its places lie apart.
double of_pieces(double spread_m, double hold, double overlap_m = 26.8, double look_alikes = 7.5,
                 double of_mine = 1.2) {
  Evidence e = convincing();
  e.overlap_m = overlap_m;
  e.weakest_hold = hold;
  e.end_on_match = 0.38;
  e.look_alikes = look_alikes;
  e.mine_look_alikes = of_mine;
  e.descriptors_compared = 6;
  e.descriptors_alike = 0.975;
  e.spread_m = spread_m;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, AmongLookAlikesPlacesThatTheWallsHoldLieTogether) {
  EXPECT_LT(of_pieces(0.9, 0.028), 0.1) << "each piece of a copy fits at its own place";
  EXPECT_LT(of_pieces(0.8, 0.02), 0.1);
  EXPECT_LT(of_pieces(0.6, 0.028), 0.9) << "so short, and less than 0.2 m at the right place";
  EXPECT_GT(of_pieces(0.6, 0.028, 45), 0.9);
  EXPECT_GT(of_pieces(0.2, 0.028), 0.9);
  EXPECT_GT(of_pieces(0.94, 0.0166), 0.9) << "they slide along the tunnel";
  EXPECT_GT(of_pieces(0.9, 0.028, 60), 0.9) << "a long overlap tells by itself";
  EXPECT_GT(of_pieces(0.9, 0.1, 26.8, 0, 0), 0.9) << "nothing looks alike";
}

TEST(Probability, AmongFewLookAlikesPlacesOfAShortOverlapThatLieALittleApartAreADoubt) {
  EXPECT_LT(of_pieces(0.42, 0.074, 24.7, 1.41, 0.17), 0.5) << "a copy";
  EXPECT_LT(of_pieces(0.36, 0.083, 16.4, 1.48, 0.06), 0.5) << "another";
  EXPECT_GT(of_pieces(0.2, 0.074, 24.7, 1.41, 0.17), 0.9) << "they lie together";
  EXPECT_GT(of_pieces(0.42, 0.074, 24.7, 1, 0.1), 0.9) << "one look-alike says little";
  EXPECT_GT(of_pieces(0.42, 0.074, 45, 1.41, 0.17), 0.9) << "a longer overlap tells";
  EXPECT_GT(of_pieces(0.42, 0.018, 24.7, 1.41, 0.17), 0.9) << "they slide along the tunnel";
  for (double m = 0.15; m < 0.4; m += 0.001)
    EXPECT_NEAR(of_pieces(m, 0.074, 24.7, 1.41), of_pieces(m + 0.001, 0.074, 24.7, 1.41), 0.05) << "no cliff";
}

/// Figures of two copies of which a third of a place resembled another, and how far their places lie apart.
double of_similar_places(double spread_m, double similar_places, double overlap_m = 18.2, double alike = 0.916) {
  Evidence e = convincing();
  e.overlap_m = overlap_m;
  e.weakest_hold = 0.0534;
  e.similar_places = similar_places;
  e.descriptors_compared = 3;
  e.descriptors_alike = alike;
  e.spread_m = spread_m;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, WhereOnlyAThirdOfAPlaceResemblesAnotherPlacesOfAShortOverlapLieTogether) {
  EXPECT_LT(of_similar_places(0.754, 0.36), 0.9);
  EXPECT_LT(of_similar_places(0.712, 0.89, 17.8, 0.949), 0.9);
  EXPECT_GT(of_similar_places(0.754, 0.15), 0.9) << "as in rough tunnels without copies";
  EXPECT_GT(of_similar_places(0.36, 0.36), 0.9);
  EXPECT_GT(of_similar_places(0.754, 0.36, 36), 0.9);
  EXPECT_GT(of_similar_places(0.754, 0.36, 18.2, 0.972), 0.9) << "the descriptors tell";
  for (double m = 0.35; m < 0.47; m += 0.001)
    EXPECT_NEAR(of_similar_places(m, 0.36), of_similar_places(m + 0.001, 0.36), 0.05) << "no cliff";
}

/// Figures of two copies of 50 m in a mine of equal tunnels, both of which were accepted once.
double of_fifty_metres(double look_alikes, double alike, double rmse_m, double overlap_m = 50) {
  Evidence e = convincing();
  e.overlap_m = overlap_m;
  e.weakest_hold = 0.066;
  e.look_alikes = look_alikes;
  e.mine_look_alikes = 1.5;
  e.descriptors_compared = 10;
  e.descriptors_alike = alike;
  e.rmse_m = rmse_m;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, AmongLookAlikesPointsThatScatterAreADoubt) {
  EXPECT_LT(of_fifty_metres(13.1, 0.959, 0.132), 0.6);
  EXPECT_GT(of_fifty_metres(13.1, 0.959, 0.112), 0.9);
  EXPECT_GT(of_fifty_metres(13.1, 0.959, 0.125, 60), of_fifty_metres(13.1, 0.959, 0.125)) << "a longer overlap tells";
  EXPECT_EQ(of_fifty_metres(13.1, 0.959, 0.112, 60), of_fifty_metres(13.1, 0.959, 0.12, 60));
  for (double m = 0.11; m < 0.13; m += 0.0002)
    EXPECT_NEAR(of_fifty_metres(13.1, 0.959, m), of_fifty_metres(13.1, 0.959, m + 0.0002), 0.05) << "no cliff";
}

/// Figures of copies of a tile or two, and of a longer piece, that were accepted once.
double of_a_piece(double overlap_m, double look_alikes, double of_mine, double compared, double alike, double hold) {
  Evidence e = convincing();
  e.overlap_m = overlap_m;
  e.look_alikes = look_alikes;
  e.mine_look_alikes = of_mine;
  e.descriptors_compared = compared;
  e.descriptors_alike = alike;
  e.weakest_hold = hold;
  e.end_on_match = 0.25;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, ALooselyHeldTileOrTwoMayBeACopyThatNobodySawTwice) {
  EXPECT_LT(of_a_piece(13.7, 0.88, 0.32, 2, 0.86, 0.052), 0.5);
  EXPECT_GT(of_a_piece(13.7, 0.88, 0.3, 2, 0.86, 0.11), 0.9) << "walls all around hold it";
  EXPECT_GT(of_a_piece(25, 0.88, 0.3, 2, 0.86, 0.052), 0.9) << "longer than a tile";
  EXPECT_GT(of_a_piece(13.7, 0.88, 0.1, 2, 0.86, 0.052), 0.9) << "in a mine that shows no copies";
  for (double m = 18; m < 27; m += 0.02)
    EXPECT_NEAR(of_a_piece(m, 0.88, 0.3, 2, 0.86, 0.052), of_a_piece(m + 0.02, 0.88, 0.3, 2, 0.86, 0.052), 0.05);
}

TEST(Probability, OneDescriptorDoesNotTellACopy) {
  EXPECT_LT(of_a_piece(18.6, 2.34, 0.86, 1, 0.966, 0.062), 0.5);
  EXPECT_NEAR(of_a_piece(18.6, 2.34, 0.86, 1, 0.966, 0.062), of_a_piece(18.6, 2.34, 0.86, 0, 0, 0.062), 0.001);
  EXPECT_GT(of_a_piece(18.6, 2.34, 0.86, 2, 0.966, 0.062), 0.9);
}

TEST(Probability, ManyDescriptorsThatDifferAreADoubtAlongAStraightTunnel) {
  EXPECT_LT(of_a_piece(80, 0.8, 0.22, 21, 0.697, 0.04), 0.9) << "a copy";
  EXPECT_GT(of_a_piece(80, 0.8, 0.22, 21, 0.76, 0.04), 0.9);
  EXPECT_GT(of_a_piece(80, 0.8, 0.22, 21, 0.697, 0.05), 0.9);
  EXPECT_GT(of_a_piece(80, 0.8, 0.1, 21, 0.697, 0.04), 0.9) << "in a mine that shows no look-alikes";
  EXPECT_GT(of_a_piece(80, 0.8, 0.22, 4, 0.697, 0.04), 0.9) << "four say little";
  EXPECT_GT(of_a_piece(100, 0.8, 0.22, 21, 0.697, 0.04), 0.9);
  for (double alike = 0.7; alike < 0.78; alike += 0.0004)
    EXPECT_NEAR(of_a_piece(80, 0.8, 0.22, 21, alike, 0.04), of_a_piece(80, 0.8, 0.22, 21, alike + 0.0004, 0.04), 0.05);
}

TEST(Probability, InAStraightTunnelWhoseEndsHardlyMatchDescriptorsThatDifferAreADoubtThoughNothingLooksAlike) {
  const auto p = [](double alike, double hold, double end_on_match, double overlap_m = 54.5) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.weakest_hold = hold;
    e.end_on_match = end_on_match;
    e.descriptors_compared = 10;
    e.descriptors_alike = alike;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.64, 0.03, 0.134), 0.1) << "a copy";
  EXPECT_GT(p(0.64, 0.03, 0.25), 0.9) << "its ends tell";
  EXPECT_GT(p(0.76, 0.03, 0.134), 0.9) << "the descriptors tell";
  EXPECT_GT(p(0.64, 0.05, 0.134), 0.9) << "it is not straight";
  EXPECT_GT(p(0.64, 0.03, 0.134, 100), 0.9) << "the overlap tells";
  for (double end = 0.1; end < 0.3; end += 0.0003) EXPECT_NEAR(p(0.64, 0.03, end), p(0.64, 0.03, end + 0.0003), 0.05);
}

TEST(Probability, TheMoreLookAlikesTheLongerTheOverlapThatIsAskedFor) {
  EXPECT_LT(of_fifty_metres(8.8, 0.909, 0.093), 0.85);
  EXPECT_GT(of_fifty_metres(7, 0.909, 0.093, 56), 0.9);
  EXPECT_LT(of_fifty_metres(9, 0.909, 0.093, 56), of_fifty_metres(7, 0.909, 0.093, 56));
  EXPECT_EQ(of_fifty_metres(17, 0.909, 0.093, 76), of_fifty_metres(12, 0.909, 0.093, 76)) << "20 m more at most";
}

TEST(Probability, WherePlacesLieApartThoughHeldTheDescriptorsOfAShortOverlapHaveToTell) {
  const auto p = [](double spread_m, double hold, double alike, double overlap_m = 27.6) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.spread_m = spread_m;
    e.weakest_hold = hold;
    e.end_on_match = 0.5;
    e.descriptors_alike = alike;
    e.descriptors_compared = 5;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.77, 0.054, 0.691), 0.75) << "a copy in equal tunnels at which nothing looked alike";
  EXPECT_GT(p(0.6, 0.054, 0.691), 0.9) << "as far as drift moves them";
  EXPECT_GT(p(0.77, 0.017, 0.691), 0.9) << "they slid along the tunnel";
  EXPECT_GT(p(0.77, 0.054, 0.83), 0.9) << "the descriptors tell";
  EXPECT_GT(p(0.77, 0.054, 0.691, 36), 0.9) << "the overlap tells";
  for (double m = 0.5; m < 0.9; m += 0.002) EXPECT_NEAR(p(m, 0.054, 0.691), p(m + 0.002, 0.054, 0.691), 0.05);
}

TEST(Probability, ThreeDescriptorsDecideWhereTheWallsHoldLooselyAndEndsHardlyMatch) {
  const auto p = [](double alike, double hold, double end_on_match) {
    Evidence e = convincing();
    e.overlap_m = 30.7;
    e.look_alikes = 0.72;
    e.mine_look_alikes = 0.15;
    e.weakest_hold = hold;
    e.end_on_match = end_on_match;
    e.descriptors_compared = 3;
    e.descriptors_alike = alike;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.64, 0.052, 0.194), 0.9) << "a copy in rough tunnels";
  EXPECT_GT(p(0.83, 0.052, 0.194), 0.9) << "the descriptors tell";
  EXPECT_GT(p(0.64, 0.07, 0.194), 0.9) << "the walls tell";
  EXPECT_GT(p(0.64, 0.052, 0.3), 0.9) << "the ends tell";
}

TEST(Probability, WherePlacesOfAShortOverlapLieNearlyAMetreApartDescriptorsHaveToAgreeWell) {
  const auto p = [](double spread_m, double alike, double overlap_m = 13.5, double compared = 3) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.spread_m = spread_m;
    e.weakest_hold = 0.019;
    e.end_on_match = 0.3;
    e.descriptors_compared = compared;
    e.descriptors_alike = alike;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(0.91, 0.889), 0.5) << "a copy in a straight tunnel, though nothing looked alike";
  EXPECT_GT(p(0.91, 0.95), 0.9);
  EXPECT_GT(p(0.75, 0.889), 0.9) << "as right ones of rough tunnels do";
  EXPECT_GT(p(0.91, 0.889, 36), 0.9) << "the overlap tells";
  EXPECT_GT(p(0.91, 0.889, 13.5, 1), 0.9);
  for (double m = 0.7; m < 0.95; m += 0.001) EXPECT_NEAR(p(m, 0.889), p(m + 0.001, 0.889), 0.05);
}

}  // namespace
}  // namespace headframe
