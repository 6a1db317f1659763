#include "client/uplink/pacing.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

using namespace std::chrono_literals;

TEST(TokenBucket, BytesWaitForTheirShareOfTheBudget) {
  TokenBucket::Time now{};
  TokenBucket bucket(1000, now);
  EXPECT_DOUBLE_EQ(bucket.take(500, now).count(), 0.5);
  EXPECT_DOUBLE_EQ(bucket.take(500, now).count(), 1.0);
  now += 1s;
  EXPECT_DOUBLE_EQ(bucket.take(1, now).count(), 0.001);
}

TEST(TokenBucket, AQuarterOfASecondIsSavedUp) {
  TokenBucket::Time now{};
  TokenBucket bucket(1000, now);
  now += 60s;
  EXPECT_EQ(bucket.take(250, now).count(), 0);
  EXPECT_GT(bucket.take(1, now).count(), 0);
}

TEST(TokenBucket, NoBudgetIsNoLimit) {
  TokenBucket bucket(0, {});
  EXPECT_EQ(bucket.take(1'000'000'000, {}).count(), 0);
}

TEST(Backoff, DoublesUpToItsMostWithJitterAndStartsAnew) {
  Backoff backoff(0.5, 4, 1);
  for (const double span_s : {0.5, 1.0, 2.0, 4.0, 4.0}) {
    const double wait_s = backoff.next_s();
    EXPECT_GE(wait_s, span_s / 2);
    EXPECT_LE(wait_s, span_s);
  }
  backoff.reset();
  EXPECT_LE(backoff.next_s(), 0.5);
  EXPECT_NE(Backoff(0.5, 4, 1).next_s(), Backoff(0.5, 4, 2).next_s());
}

}  // namespace
}  // namespace headframe
