#include "server/security/attempt_limiter.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

using boost::asio::ip::address;
using boost::asio::ip::make_address;
using namespace std::chrono_literals;

struct Attempts : testing::Test {
  void fail(const address& from, int times) {
    for (int i = 0; i < times; ++i) limiter.failed(from, now);
  }
  AttemptLimits limits{.failures = 3, .forgiven_per_s = 0.5, .addresses = 2};
  AttemptLimiter limiter{limits};
  AttemptLimiter::Time now{};
  const address a = make_address("10.0.0.1"), b = make_address("10.0.0.2"), c = make_address("10.0.0.3");
};

TEST_F(Attempts, AsManyAsTheLimitAndNoMore) {
  fail(a, 2);
  EXPECT_TRUE(limiter.allowed(a, now));
  fail(a, 1);
  EXPECT_FALSE(limiter.allowed(a, now));
  EXPECT_TRUE(limiter.allowed(b, now)) << "another address is not concerned";
}

TEST_F(Attempts, AreForgottenWithTime) {
  fail(a, 1000);  // more do not make it longer
  now += 1999ms;
  EXPECT_FALSE(limiter.allowed(a, now));
  now += 1ms;
  EXPECT_TRUE(limiter.allowed(a, now));
  fail(a, 1);
  EXPECT_FALSE(limiter.allowed(a, now)) << "one was forgotten, one was had";
  now += 6s;
  fail(a, 2);
  EXPECT_TRUE(limiter.allowed(a, now)) << "all were forgotten";
}

TEST_F(Attempts, AClockThatGoesBackForgivesNothing) {
  fail(a, 3);
  EXPECT_FALSE(limiter.allowed(a, now - 1h));
  EXPECT_FALSE(limiter.allowed(a, now));
}

TEST_F(Attempts, TheTableIsBounded) {
  fail(a, 3);
  fail(b, 3);
  fail(a, 1);
  fail(c, 3);
  EXPECT_EQ(limiter.remembered(), 2U);
  EXPECT_FALSE(limiter.allowed(a, now));
  EXPECT_TRUE(limiter.allowed(b, now)) << "it failed longest ago";
  EXPECT_FALSE(limiter.allowed(c, now));
}

TEST_F(Attempts, ANetworkOfIpv6IsOneAndAMappedAddressIsItsIpv4) {
  fail(make_address("2001:db8:0:1::1"), 3);
  EXPECT_FALSE(limiter.allowed(make_address("2001:db8:0:1:ffff::2"), now));
  EXPECT_TRUE(limiter.allowed(make_address("2001:db8:0:2::1"), now));
  fail(make_address("::ffff:10.0.0.1"), 3);
  EXPECT_FALSE(limiter.allowed(a, now));
}

}  // namespace
}  // namespace headframe
