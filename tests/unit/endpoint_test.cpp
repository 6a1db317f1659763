#include "common/endpoint.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

TEST(Endpoint, IsReadAsItIsWritten) {
  for (const std::string text : {"127.0.0.1:7447", "[::1]:0", "base.mine:65535"})
    EXPECT_EQ(to_string(parse_endpoint(text).value()), text);
  for (const std::string text : {"", ":1", "host", "host:", "host:65536", "host:-1", "host:1x", "::1:80", "[]:1"})
    EXPECT_FALSE(parse_endpoint(text)) << text;
}

TEST(Endpoint, APeerHasAPort) {
  EXPECT_EQ(parse_peer("[::1]:1")->port, 1);
  EXPECT_FALSE(parse_peer("[::1]:0"));
  EXPECT_NE(parse_peer("host").error().message.find("\"host\" is no HOST:PORT"), std::string::npos);
}

TEST(Endpoint, SeveralPeersHaveCommasBetween) {
  const auto peers = parse_peers("base:1,[::1]:2");
  ASSERT_TRUE(peers);
  ASSERT_EQ(peers->size(), 2U);
  EXPECT_EQ(to_string((*peers)[0]), "base:1");
  EXPECT_EQ(to_string((*peers)[1]), "[::1]:2");
  for (const char* text : {"", ",", "base:1,", ",base:1", "base:1,,base:2", "base:1, base:2:3", "base:1,base:0"})
    EXPECT_FALSE(parse_peers(text)) << text;
}

TEST(Endpoint, TheLoopbackIsReachedFromThisMachineOnly) {
  for (const char* host : {"127.0.0.1", "127.255.255.254", "::1", "localhost"})
    EXPECT_TRUE(is_loopback({host, 1})) << host;
  for (const char* host : {"128.0.0.1", "126.255.255.255", "0.0.0.0", "::", "::2", "127.0.0.1.mine", "base.mine", ""})
    EXPECT_FALSE(is_loopback({host, 1})) << host;
}

TEST(Endpoint, EveryAddressIsNoneToConnectTo) {
  for (const char* host : {"0.0.0.0", "::", "0:0:0:0:0:0:0:0"}) EXPECT_TRUE(is_any_address({host, 1})) << host;
  for (const char* host : {"0.0.0.1", "10.0.0.0", "::1", "127.0.0.1", "base.mine", ""})
    EXPECT_FALSE(is_any_address({host, 1})) << host;
}

}  // namespace
}  // namespace headframe
