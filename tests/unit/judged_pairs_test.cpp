#include "server/merge/judged_pairs.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

const OrderedPair one_and_two{1, 2};

JudgedOn at_its_placement(std::size_t clouds_a, std::size_t clouds_b) { return {.clouds = {clouds_a, clouds_b}}; }

JudgedOn at_its_end(std::size_t clouds_a, std::size_t clouds_b) {
  return {.complete = 2, .clouds = {clouds_a, clouds_b}};
}

JudgedOn as_a_whole(std::size_t search, std::size_t clouds) {
  JudgedOn on;
  on.search = search;
  on.clouds = {clouds};
  return on;
}

TEST(JudgedPairs, APlacementThatMovesBackAndForthIsJudgedOnceAtEachEnd) {
  JudgedPairs pairs;
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(12, 9)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(13, 9)));
  EXPECT_TRUE(pairs.judged_on(one_and_two, at_its_placement(12, 9)));
  EXPECT_TRUE(pairs.judged_on(one_and_two, at_its_placement(13, 9)));
  EXPECT_FALSE(pairs.judged_on({1, 3}, at_its_placement(13, 9))) << "another pair";
  pairs.forget(2, 1);
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(12, 9))) << "what it was based on has changed";
}

TEST(JudgedPairs, APlacementIsJudgedOnceMoreWhenBothHaveEnded) {
  JudgedPairs pairs;
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(12, 9)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_end(12, 9)));
  EXPECT_TRUE(pairs.judged_on(one_and_two, at_its_end(12, 9)));
}

TEST(JudgedPairs, OfASearchOnlyTheLastVerdictCounts) {
  JudgedPairs pairs;
  EXPECT_FALSE(pairs.judged_on(one_and_two, as_a_whole(1, 20)));
  EXPECT_TRUE(pairs.judged_on(one_and_two, as_a_whole(1, 20)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, as_a_whole(2, 20)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, as_a_whole(1, 20)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(12, 9)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, as_a_whole(1, 20)));
}

TEST(JudgedPairs, WhatIsRememberedOfAPairIsBounded) {
  JudgedPairs pairs;
  for (std::size_t n = 0; n < 9; ++n) EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(n, 1)));
  EXPECT_TRUE(pairs.judged_on(one_and_two, at_its_placement(1, 1)));
  EXPECT_FALSE(pairs.judged_on(one_and_two, at_its_placement(0, 1)));
}

}  // namespace
}  // namespace headframe
