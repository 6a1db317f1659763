#include <gtest/gtest.h>

#include <cmath>

#include "server/merge/merge_config.hpp"
#include "server/verification/verification.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

using test::convincing;

TEST(Probability, WhereAllSessionsShowManyCopiesALongerOverlapIsAskedFor) {
  Evidence e = convincing();
  const auto asked = [&](double repetition, double aliases = 0) {
    e.repetition = repetition;
    e.aliases = aliases;
    return asked_overlap_m(e);
  };
  EXPECT_EQ(asked(0.3), 0) << "as in the recordings";
  EXPECT_NEAR(asked(0.4), 20, 1e-9);
  EXPECT_NEAR(asked(0.65), 70, 1e-9);
  EXPECT_EQ(asked(5), 70);
  EXPECT_EQ(asked(0.4, 1), 42) << "the copies of the pair itself say more";
  EXPECT_EQ(asked(0.3, 0.5), 21);
  EXPECT_EQ(asked(5, 3), 82);
  EXPECT_EQ(asked(5, 4), 100);
  Judgement j{RegistrationStatus::converged, Pose::Identity(), convincing()};
  j.evidence.repetition = 1;
  const auto p = [&](double overlap_m) {
    j.evidence.overlap_m = overlap_m;
    weigh(j);
    return j.evidence.probability;
  };
  EXPECT_LT(p(39), 0.9);
  EXPECT_GT(j.evidence.probability_if_unique, 0.95);
  EXPECT_GT(p(70), 0.95);
}

TEST(Probability, AmongLookAlikesALongerOverlapIsAskedFor) {
  Judgement j{RegistrationStatus::converged, Pose::Identity(), convincing()};
  const auto p = [&](double look_alikes, double overlap_m) {
    j.evidence.look_alikes = look_alikes;
    j.evidence.overlap_m = overlap_m;
    weigh(j);
    return j.evidence.probability;
  };
  const double accepted = MergeConfig{}.accept_probability;
  EXPECT_GT(p(0, 20), accepted) << "nothing looks alike, as in a cave";
  EXPECT_GT(p(0.9, 26), accepted) << "rough drifts";
  EXPECT_LT(p(3.3, 29), p(0, 29)) << "a copy of a tunnel piece that was believed";
  EXPECT_EQ(j.evidence.probability_if_unique, p(0, 29));
  EXPECT_LT(p(5.3, 60), p(0, 60)) << "one as long as three pieces";
  EXPECT_EQ(p(5, 90), p(100, 90)) << "90 m tell, wherever it is";
  EXPECT_EQ(asked_among_look_alikes_m({}), 0);
  for (double n = 0; n < 6; n += 0.05) EXPECT_NEAR(p(n, 40), p(n + 0.05, 40), 0.05) << "no cliff";
}

TEST(Probability, AShortOverlapAmongManyLookAlikesIsNotBelieved) {
  const auto p = [](double overlap_m, double look_alikes) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.look_alikes = look_alikes;
    e.descriptors_compared = 5;
    e.descriptors_alike = 0.96;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_GT(p(28, 8), 0.9) << "as in tunnel-four";
  EXPECT_LT(p(23.8, 5.3), 0.9) << "a copy";
  EXPECT_LT(p(12.7, 7.8), 0.5) << "a copy";
  EXPECT_GT(p(18.8, 1.1), 0.9) << "one look-alike is told apart";
  EXPECT_GT(p(12, 2.6), 0.9) << "few look-alikes";
  EXPECT_NEAR(p(27.99, 8), p(28.01, 8), 1e-3) << "no cliff";
}

TEST(Probability, ThreeDescriptorsThatDifferAreADoubtBesideALookAlike) {
  const auto p = [](double compared, double look_alikes = 0.267, double alike = 0.582) {
    Evidence e = convincing();
    e.overlap_m = 13;
    e.weakest_hold = 0.067;
    e.look_alikes = look_alikes;
    e.descriptors_compared = compared;
    e.descriptors_alike = alike;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(p(3), 0.85) << "a copy of mixed tunnels";
  EXPECT_GT(p(2), 0.9) << "two tell little";
  EXPECT_GT(p(3, 0), 0.9) << "nothing looks alike";
  EXPECT_GT(p(3, 0.267, 0.83), 0.9) << "they agree";
}

TEST(Probability, AMineOfCopiesAsksForDescriptorsThatAreMoreAlike) {
  const auto p = [](double aliases, double alike) {
    Evidence e = convincing();
    e.aliases = aliases;
    e.descriptors_compared = 12;
    e.descriptors_alike = alike;
    return probability(RegistrationStatus::converged, e);
  };
  const auto odds = [&](double aliases, double alike) {
    const double chance = p(aliases, alike);
    return std::log(chance / (1 - chance));
  };
  EXPECT_GT(odds(1, 0.85) - odds(1, 0.76), odds(0, 0.85) - odds(0, 0.76)) << "below .85 a copy's mine asks for more";
}

TEST(Probability, WhereAnotherPlaceFitsTheDescriptorsOfAShortOverlapHaveToTell) {
  double hold = 0.08;
  const auto p = [&](double likeness, double alike, double count = 5, double overlap_m = 23) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.weakest_hold = hold;
    e.aliases = 0.2 * likeness;
    e.descriptors_alike = alike;
    e.descriptors_compared = count;
    const double beside_another = probability(RegistrationStatus::converged, e);
    e.aliases = 0;
    e.look_alikes = 0.25 * likeness;
    return std::max(beside_another, probability(RegistrationStatus::converged, e));
  };
  EXPECT_GT(p(0, 0.77), 0.9);
  EXPECT_LT(p(1, 0.77), 0.6);
  EXPECT_GT(p(1, 0.84), 0.9);
  EXPECT_GT(p(1, 0.77, 2), 0.9) << "two tell little";
  EXPECT_GT(p(1, 0.77, 3), p(1, 0.77, 4));
  EXPECT_GT(p(1, 0.77, 5, 36), 0.9) << "a longer overlap tells by itself";
  EXPECT_LT(p(1, 0.77, 5, 26), p(1, 0.77, 5, 31));
  EXPECT_NEAR(p(1, 0.829), p(1, 0.831), 0.05) << "no cliff";
  EXPECT_LT(p(0.258 / 0.25, 0.691, 5, 27.6), 0.6) << "a copy in equal tunnels";
  hold = 0.11;
  EXPECT_GT(p(1, 0.77), 0.9) << "a quarter of a look-alike tells nothing about walls that hold";
  EXPECT_LT(p(10, 0.77), 0.6) << "copies were seen";
}

TEST(Probability, APlacementIsAnAliasIfItIsNearlyAsProbableAndFitsAsWell) {
  Evidence e, other;
  e.probability_if_unique = 0.994;
  e.matched_share = 0.9;
  const auto alias = [&](double probability, double matched_share) {
    other.probability_if_unique = probability;
    other.matched_share = matched_share;
    return alias_of(e, other);
  };
  EXPECT_EQ(alias(0.994, 0.9), 1);
  EXPECT_NEAR(alias(0.9, 0.86), 1, 1e-9) << "a copy matches a little less";
  EXPECT_NEAR(alias(0.9, 0.84), 0.5, 1e-9);
  EXPECT_EQ(alias(0.9, 0.81), 0) << "it fits worse";
  const auto with_odds = [](double odds) { return odds / (1 + odds); };
  const double own = odds(0.994);
  EXPECT_EQ(alias(with_odds(own * std::exp(-2.9)), 0.9), 1);
  EXPECT_NEAR(alias(with_odds(own * std::exp(-3.75)), 0.9), 0.5, 1e-6);
  EXPECT_EQ(alias(with_odds(own * std::exp(-4.6)), 0.9), 0) << "far less probable";
  EXPECT_EQ(alias(0, 0.9), 0);
  e.probability_if_unique = 0;
  EXPECT_EQ(alias(0, 0.9), 0);
  EXPECT_EQ(alias(0.5, 0.9), 1);
  EXPECT_NEAR(odds(1), 1e9, 1) << "finite";
}

TEST(Probability, CopiesCountMoreWhereTheDescriptorsDifferAndNeverLess) {
  Evidence e;
  e.aliases = 3;
  e.descriptors_compared = 6;
  const auto counted = [&](double alike) {
    e.descriptors_alike = alike;
    return counted_aliases(e);
  };
  EXPECT_EQ(counted(1), 3) << "as alike as copies are";
  EXPECT_EQ(counted(0.76), 3);
  EXPECT_EQ(asked_overlap_m(e), 82);
  EXPECT_NEAR(counted(0.74), 4.5, 1e-9) << "unlike: half more";
  EXPECT_NEAR(counted(0.72), 6, 1e-9);
  EXPECT_EQ(counted(0.5), 6) << "twice at most";
  e.descriptors_compared = 3;
  EXPECT_EQ(counted(0.5), 4.5) << "three keyframes are few";
}

/// What it is with so much of this, over an overlap whose descriptors are so alike.
double with_overlap(double Evidence::*member, double value, double overlap_m, double alike, double compared) {
  Evidence e = convincing();
  e.*member = value;
  e.overlap_m = overlap_m;
  e.descriptors_alike = alike;
  e.descriptors_compared = compared;
  return probability(RegistrationStatus::converged, e);
}

TEST(Probability, AmongManyLookAlikesOnlyTheSameDescriptorsTellAShortOverlap) {
  const auto p = [](double look_alikes, double overlap_m, double alike, double compared) {
    return with_overlap(&Evidence::look_alikes, look_alikes, overlap_m, alike, compared);
  };
  EXPECT_LT(p(8, 33, 0.88, 6), 0.9) << "a copy of a tunnel piece, driven a little aside";
  EXPECT_GT(p(8, 33, 0.96, 6), 0.9);
  EXPECT_LT(p(8, 33, 0.91, 6), p(8, 33, 0.96, 6));
  EXPECT_LT(p(4.4, 44, 0.928, 11), 0.9) << "one of so many copies that its descriptors agree";
  EXPECT_LT(p(14, 41, 0.938, 9), 0.9) << "another";
  EXPECT_GT(p(3.4, 56, 0.935, 11), 0.9);
  EXPECT_GT(p(2, 35, 0.94, 6), 0.9) << "of few copies none has such descriptors";
  EXPECT_LT(p(14, 57, 0.921, 9), p(11, 57, 0.921, 9));
  double of_mine = 0.44;
  const auto in_mine_of_copies = [&](double look_alikes, double overlap_m, double alike, double compared) {
    Evidence e = convincing();
    e.mine_look_alikes = of_mine;
    e.look_alikes = look_alikes;
    e.overlap_m = overlap_m;
    e.descriptors_alike = alike;
    e.descriptors_compared = compared;
    return probability(RegistrationStatus::converged, e);
  };
  EXPECT_LT(in_mine_of_copies(1.4, 24, 0.932, 4), 0.5) << "a copy";
  EXPECT_LT(in_mine_of_copies(2.6, 44, 0.930, 9), 0.9) << "another";
  EXPECT_GT(in_mine_of_copies(0.95, 38, 0.932, 6), 0.9) << "where hardly anything looks alike";
  of_mine = 0.67;
  EXPECT_LT(in_mine_of_copies(3.4, 44, 0.928, 11), 0.9) << "a third";
  of_mine = 0.25;
  EXPECT_GT(in_mine_of_copies(1.8, 21, 0.93, 4), 0.9) << "tunnel-four";
  EXPECT_GT(in_mine_of_copies(3.5, 47, 0.914, 9), 0.9) << "tunnel-four and tunnel-apart";
  for (of_mine = 0.3; of_mine < 0.5;) {
    const double before = in_mine_of_copies(3.2, 44, 0.93, 9);
    of_mine += 0.001;
    EXPECT_NEAR(in_mine_of_copies(3.2, 44, 0.93, 9), before, 0.05) << "no cliff";
  }
  for (double n = 0.9; n < 5; n += 0.004)
    EXPECT_NEAR(p(n, 41, 0.938, 9), p(n + 0.004, 41, 0.938, 9), 0.05) << "no cliff";
  EXPECT_GT(p(8, 33, 0, 0), 0.9) << "of two families";
  EXPECT_GT(p(8, 33, 0.88, 1), p(8, 33, 0.88, 4)) << "one keyframe says little";
  EXPECT_LT(p(8, 51, 0.88, 9), 0.9);
  EXPECT_GT(p(8, 61, 0.88, 9), 0.9) << "longer than the pieces";
  EXPECT_LT(p(18, 51, 0.85, 9), 0.9) << "a mine of nothing but copies";
  EXPECT_GT(p(18, 71, 0.85, 9), 0.9);
  EXPECT_GT(p(1, 33, 0.88, 6), 0.9) << "one look-alike says little";
  for (double alike = 0.84; alike < 0.99; alike += 0.0001)
    EXPECT_NEAR(p(8, 33, alike, 6), p(8, 33, alike + 0.0001, 6), 0.05) << "no cliff";
}

TEST(Probability, InAMineThatLooksLikeItselfAllPlacesOfAShortOverlapHaveToAgree) {
  double hold = 0.07;
  const auto p = [&](double look_alikes, double overlap_m, double agreeing) {
    Evidence e = convincing();
    e.weakest_hold = hold;
    e.end_on_match = 0.4;
    e.look_alikes = look_alikes;
    e.overlap_m = overlap_m;
    e.descriptors_compared = 7;
    e.descriptors_alike = 0.96;
    e.places_agreeing = agreeing;
    return probability(RegistrationStatus::converged, e);
  };
  const double all = convincing().places;
  EXPECT_GT(p(6, 37, all), 0.9);
  EXPECT_LT(p(6, 37, all - 1), 0.5) << "a copy";
  EXPECT_GT(p(6, 60, all - 1), p(6, 59, all - 1));
  EXPECT_NEAR(p(6, 60, all - 1), p(6, 61, all - 1), 0.05);
  EXPECT_GT(p(1, 37, all - 1), 0.9) << "in a mine that does not look like itself, a place may slide";
  hold = 0.05;
  EXPECT_LT(p(6, 37, all - 1), 0.5);
  hold = 0.03;
  EXPECT_GT(p(6, 37, all - 1), 0.5) << "it may slide where the walls hardly hold it: tunnel-four";
}

TEST(Probability, InAMineThatLooksLikeItselfDescriptorsOfALongOverlapHaveToAgreeToo) {
  const auto p = [](double of_mine, double alike) {
    return with_overlap(&Evidence::mine_look_alikes, of_mine, 66, alike, 19);
  };
  EXPECT_LT(p(0.3, 0.64), std::min(0.9, p(0, 0.64)));
  EXPECT_GT(p(0.3, 0.79), 0.9);
}

TEST(Probability, InAMineThatLooksLikeItselfAShortOverlapIsTrustedOnlyWithDescriptorsThatAgree) {
  const auto p = [](double of_mine, double overlap_m, double alike, double compared) {
    return with_overlap(&Evidence::mine_look_alikes, of_mine, overlap_m, alike, compared);
  };
  EXPECT_EQ(p(0.1, 31, 0.79, 2), p(0, 31, 0.79, 2)) << "a chance look-alike in a kilometre says nothing of the mine";
  EXPECT_GT(p(0.1, 31, 0.79, 2), 0.9);
  EXPECT_LT(p(0.4, 31, 0.79, 2), 0.5) << "a copy, and the two sessions have shown no other";
  EXPECT_NEAR(p(0.4, 31, 0.79, 2), p(3, 31, 0.79, 2), 1e-9);
  EXPECT_NEAR(p(0.4, 61, 0.79, 2), p(0, 61, 0.79, 2), 1e-3) << "longer than the pieces";
  EXPECT_LT(p(0.4, 45, 0.90, 2), 0.9);
  EXPECT_GT(p(0.3, 45, 0.90, 2), 0.9) << "a look-alike or two in all that is known";
  EXPECT_EQ(p(0.4, 31, 0.93, 2), p(0, 31, 0.93, 2)) << "the descriptors tell";
  EXPECT_EQ(p(0.3, 29, 0, 0), p(0, 29, 0, 0)) << "of two families";
  EXPECT_LT(p(0.3, 14, 0, 0), 0.7);
  Evidence straight = convincing();
  straight.overlap_m = 83;
  straight.descriptors_compared = 16;
  straight.descriptors_alike = 0.89;
  straight.weakest_hold = 0.05;
  const double crooked = probability(RegistrationStatus::converged, straight);
  straight.mine_look_alikes = 0.4;
  EXPECT_NEAR(probability(RegistrationStatus::converged, straight), crooked, 1e-3);
  straight.weakest_hold = 0.037;
  EXPECT_LT(probability(RegistrationStatus::converged, straight), 0.9) << "a straight tunnel is copied farther";
  straight.overlap_m = 101;
  EXPECT_GT(probability(RegistrationStatus::converged, straight), 0.9);
  straight.overlap_m = 62;
  straight.descriptors_alike = 0.915;
  straight.look_alikes = 4.4;
  straight.weakest_hold = 0.044;
  EXPECT_GT(probability(RegistrationStatus::converged, straight), 0.9) << "three demands, and the longest counts";
  straight.overlap_m = 58;
  straight.descriptors_alike = 0.933;
  straight.weakest_hold = 0.026;
  EXPECT_LT(probability(RegistrationStatus::converged, straight), 0.9) << "a copy, though its descriptors agree";
  Evidence two;
  two.look_alikes = 1;
  EXPECT_EQ(looks_like_itself(two), 0);
  two.look_alikes = 2;
  EXPECT_EQ(looks_like_itself(two), 1) << "two look-alikes say the same of the mine";
  for (double of_mine = 0.05; of_mine < 0.45; of_mine += 0.002)
    EXPECT_NEAR(p(of_mine, 31, 0.91, 4), p(of_mine + 0.002, 31, 0.91, 4), 0.07) << "no cliff";
}

}  // namespace
}  // namespace headframe
