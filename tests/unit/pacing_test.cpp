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

TEST(TokenBucket, AClockThatJumpsNeitherSavesNorOwes) {
  TokenBucket::Time now{};
  TokenBucket bucket(1000, now);
  now += std::chrono::hours(24);
  EXPECT_EQ(bucket.take(250, now).count(), 0);
  now -= std::chrono::hours(24);
  EXPECT_DOUBLE_EQ(bucket.take(100, now).count(), 0.1);
}

TEST(TokenBucket, TheRateMayChangeWhileItRuns) {
  TokenBucket::Time now{};
  TokenBucket bucket(0, now);
  now += 60s;
  bucket.set_rate(1000, now);
  EXPECT_DOUBLE_EQ(bucket.take(500, now).count(), 0.5) << "no limit before is no saving now";
  bucket.set_rate(500, now);
  EXPECT_DOUBLE_EQ(bucket.take(0, now).count(), 1.0) << "the debt is paid at the new rate";
  bucket.set_rate(0, now);
  EXPECT_EQ(bucket.take(1'000'000, now).count(), 0);
}

TEST(Pacing, TheTighterBudgetCounts) {
  EXPECT_EQ(tighter(0, 0), 0);
  EXPECT_EQ(tighter(0, 5), 5);
  EXPECT_EQ(tighter(7, 0), 7);
  EXPECT_EQ(tighter(7, 5), 5);
}

TEST(Pacing, AChunkTakesAtMostFiftyMilliseconds) {
  EXPECT_EQ(chunk_bytes_at(0), 8192U);
  EXPECT_EQ(chunk_bytes_at(1e9), 8192U);
  EXPECT_EQ(chunk_bytes_at(8000), 368U);
  EXPECT_EQ(chunk_bytes_at(100), 256U);
  for (const double rate : {6000.0, 20000.0, 100000.0, 164480.0})
    EXPECT_LE(static_cast<double>(chunk_bytes_at(rate) + 32) / rate, 0.0501) << rate;
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
