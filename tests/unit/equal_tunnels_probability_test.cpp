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
double of_a_piece(double overlap_m, double look_alikes, double of_mine, double compared, double alike, double hold,
                  double end_on_match = 0.25) {
  Evidence e = convincing();
  e.overlap_m = overlap_m;
  e.look_alikes = look_alikes;
  e.mine_look_alikes = of_mine;
  e.descriptors_compared = compared;
  e.descriptors_alike = alike;
  e.weakest_hold = hold;
  e.end_on_match = end_on_match;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, ALooselyHeldTileOrTwoMayBeACopyThatNobodySawTwice) {
  EXPECT_LT(of_a_piece(13.7, 0.88, 0.32, 2, 0.86, 0.052), 0.9);
  EXPECT_LT(of_a_piece(13.7, 0.88, 0.32, 2, 0.86, 0.06), 0.9);
  EXPECT_GT(of_a_piece(13.7, 0.88, 0.3, 2, 0.86, 0.11), 0.9) << "walls all around hold it";
  EXPECT_GT(of_a_piece(75, 0.88, 0.3, 2, 0.86, 0.052), 0.9) << "longer than three tiles";
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
  EXPECT_LT(p(0.77, 0.06, 0.691), 0.75) << "a copy in equal tunnels at which nothing looked alike";
  EXPECT_LT(p(0.77, 0.06, 0.762), 0.9);
  EXPECT_GT(p(0.6, 0.06, 0.762), 0.9) << "as far as drift moves them";
  EXPECT_GT(p(0.77, 0.06, 0.83), 0.9) << "the descriptors tell";
  EXPECT_GT(p(0.77, 0.06, 0.762, 36), 0.9) << "the overlap tells";
  for (double m = 0.5; m < 0.9; m += 0.002) EXPECT_NEAR(p(m, 0.06, 0.762), p(m + 0.002, 0.06, 0.762), 0.05);
}

TEST(Probability, ANearlyStraightTunnelMayBeACopyThoughNothingLooksAlike) {
  const auto p = [](double overlap_m, double hold, double compared, double alike, double end_on_match = 0.3) {
    return of_a_piece(overlap_m, 0, 0, compared, alike, hold, end_on_match);
  };
  EXPECT_LT(p(54.5, 0.03, 10, 0.64), 0.6) << "a copy of equal tunnels";
  EXPECT_LT(p(13.5, 0.019, 3, 0.889), 0.9) << "another";
  EXPECT_LT(p(44.5, 0.036, 9, 0.834), 0.9) << "one of rough tunnels";
  EXPECT_LT(p(30.7, 0.0524, 3, 0.64), 0.9) << "another";
  EXPECT_GT(p(30.7, 0.0524, 1, 0.64), 0.9) << "one descriptor says little";
  EXPECT_EQ(p(50, 0.036, 9, 0.834), p(55, 0.036, 9, 0.834)) << "most are right: people shall look at it";
  EXPECT_GT(p(44.5, 0.06, 9, 0.834), 0.9) << "the walls tell";
  EXPECT_LT(p(60.3, 0.036, 11, 0.876, 0.4), 0.9);
  EXPECT_GT(p(28.9, 0.036, 5, 0.878, 0.5), 0.9) << "between smooth pillars, whose ends tell";
  EXPECT_GT(p(44.5, 0.036, 9, 0.92), 0.9) << "the descriptors tell";
  EXPECT_LT(p(60.3, 0.0497, 11, 0.876), 0.9) << "three tiles";
  EXPECT_GT(p(75, 0.036, 9, 0.834), 0.9) << "the overlap tells";
  for (double hold = 0.045; hold < 0.065; hold += 0.00005)
    EXPECT_NEAR(p(44.5, hold, 9, 0.834), p(44.5, hold + 0.00005, 9, 0.834), 0.05);
}

}  // namespace
}  // namespace headframe
