// Where a server that stands by passes connections on to, and where it does not.
#include "server/relay_target.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

const Endpoint own{"192.0.2.2", 7447}, own_loopback{"127.0.0.1", 7557};

std::vector<ServerRecord> servers(const std::string& robots, const std::string& http) {
  ServerRecord self{"b", "192.0.2.2:7447", "192.0.2.2:7448", false, true, 0, 0, 0};
  ServerRecord active{"a", robots, http, true, false, 0, 0, 0, true};
  return {self, active};
}

std::string where(const std::string& at, const Endpoint& from = own) {
  const auto target = relay_target(servers(at, "192.0.2.9:1"), Door::robots, from);
  return target ? to_string(*target) : target.error().message;
}

void expect_unavailable(const std::vector<ServerRecord>& all) {
  const auto target = relay_target(all, Door::robots, own);
  ASSERT_FALSE(target);
  EXPECT_EQ(target.error().code, ErrorCode::unavailable);
}

TEST(RelayTarget, IsTheSameDoorOfTheActiveServer) {
  const auto all = servers("192.0.2.1:7447", "[2001:db8::1]:7448");
  EXPECT_EQ(to_string(relay_target(all, Door::robots, own).value()), "192.0.2.1:7447");
  EXPECT_EQ(to_string(relay_target(all, Door::operators, own).value()), "[2001:db8::1]:7448");
  EXPECT_EQ(where("base.example:7447"), "base.example:7447");
}

TEST(RelayTarget, IsNoneWhileNobodyIsActiveOrItIsThisOneOrAnOlderOne) {
  expect_unavailable({});
  auto all = servers("192.0.2.1:7447", "192.0.2.1:7448");
  all[1].relayed.reset();
  expect_unavailable(all);
  all = servers("192.0.2.1:7447", "192.0.2.1:7448");
  all[1].is_active = false;
  expect_unavailable(all);
  all[0].is_active = true;
  expect_unavailable(all);
}

TEST(RelayTarget, IsNotThisServersOwnAddress) {
  EXPECT_NE(where("192.0.2.2:7447").find("give it another --listen, which other machines reach"), std::string::npos);
  EXPECT_EQ(where("192.0.2.2:7449"), "192.0.2.2:7449");
  EXPECT_EQ(where("192.0.2.3:7447"), "192.0.2.3:7447");
}

TEST(RelayTarget, IsOnALoopbackForALoopbackOnly) {
  for (const char* loopback : {"127.0.0.1:7447", "127.0.0.9:7447", "[::1]:7447", "localhost:7447"}) {
    EXPECT_NE(where(loopback).find("reached from its machine alone"), std::string::npos) << loopback;
    EXPECT_EQ(where(loopback, own_loopback), loopback);
    EXPECT_NE(where(loopback, {"0.0.0.0", 7557}).find("reached from its machine alone"), std::string::npos);
  }
}

TEST(RelayTarget, IsNotOnAnotherMachinesLoopback) {
  auto all = servers("127.0.0.1:7447", "192.0.2.1:7448");
  all[1].shares_loopback = false;
  EXPECT_EQ(relay_target(all, Door::robots, own_loopback).error().code, ErrorCode::refused);
  EXPECT_TRUE(relay_target(all, Door::operators, own_loopback));
}

TEST(RelayTarget, IsNoAnyAddressAndNoNonsense) {
  for (const char* any : {"0.0.0.0:7447", "[::]:7447"})
    EXPECT_NE(where(any).find("set public in [server] there"), std::string::npos) << any;
  EXPECT_NE(where("nonsense").find("which is no address"), std::string::npos);
  EXPECT_NE(where("192.0.2.1:0").find("which is no address"), std::string::npos);
}

}  // namespace
}  // namespace headframe
