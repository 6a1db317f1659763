// When another placement is an alias, and how many look-alikes say that a mine looks like itself.

#include <gtest/gtest.h>

#include <cmath>

#include "server/verification/evidence.hpp"

namespace headframe {
namespace {

TEST(Alias, APlacementIsAnAliasIfItIsNearlyAsProbableAndFitsAsWell) {
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

TEST(Alias, TwoLookAlikesOrAFewOfAllSessionsSayThatTheMineLooksLikeItself) {
  Evidence e;
  e.look_alikes = 1;
  EXPECT_EQ(looks_like_itself(e), 0);
  e.look_alikes = 2;
  EXPECT_EQ(looks_like_itself(e), 1);
  e.look_alikes = 0;
  e.mine_look_alikes = 0.1;
  EXPECT_NEAR(looks_like_itself(e), 0, 1e-12);
  e.mine_look_alikes = 0.301;
  EXPECT_EQ(looks_like_itself(e), 1);
}

}  // namespace
}  // namespace headframe
