#include "server/operator/http_rules.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

std::string request(const std::string& fields, const std::string& version = "HTTP/1.1") {
  return "POST /api/v1/merge " + version + "\r\n" + fields + "\r\n";
}

TEST(HttpRules, WhatTwoProgramsCouldReadDifferentlyIsRefused) {
  EXPECT_FALSE(header_fault(request("Host: a\r\n")));
  EXPECT_FALSE(header_fault(request("host:a\r\nTransfer-Encoding: Chunked \r\n")));
  EXPECT_FALSE(header_fault(request("", "HTTP/1.0"))) << "it knew no Host";
  for (const char* fields :
       {"", "X: y\r\n", "Host: a\r\nHost: a\r\n", "Host: a\r\nX: y\r\n z\r\n", "Host: a\r\nX: y\r\n\tz\r\n",
        "Host: a\r\nTransfer-Encoding: gzip\r\n", "Host: a\r\nTransfer-Encoding: gzip, chunked\r\n",
        "Host: a\r\nTransfer-Encoding: \r\n", "Host: a\r\nTransfer-Encoding: identity\r\n",
        "Host: a\r\nTransfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
        "Host: a\r\nTransfer-Encoding: chunked\r\nContent-Length: 5\r\n"})
    EXPECT_TRUE(header_fault(request(fields))) << fields;
}

TEST(HttpRules, EachPortHasACookieOfItsOwn) {
  EXPECT_EQ(page_cookie_name("127.0.0.1:7448"), "headframe-7448");
  EXPECT_EQ(page_cookie_name("[::1]:7448"), "headframe-7448");
  for (const char* host : {"base.mine.example", "[::1]", "", "a:", "a:1; Domain=b", "a:1x"})
    EXPECT_EQ(page_cookie_name(host), "headframe") << host;
  EXPECT_EQ(cookie_value("headframe-7448=ab", "headframe-7448"), "ab");
  EXPECT_EQ(cookie_value("x=1; headframe-7448=ab; y=2", "headframe-7448"), "ab");
  EXPECT_EQ(cookie_value("x=1;headframe=ab", "headframe"), "ab");
  for (const char* without : {"", ";", "headframe", "xheadframe=ab", "headframe-7448=ab", "a=headframe=ab", "; ;  "})
    EXPECT_EQ(cookie_value(without, "headframe"), "") << without;
}

TEST(HttpRules, ANameThatAStrangerMayOwnIsNotOurs) {
  for (const char* host : {"127.0.0.1:7448", "127.0.0.1", "[::1]:7448", "[::1]", "localhost:7448", "headframe:7448",
                           "10.0.0.7:7448", "base.mine.example:7448", "BASE.mine.example"})
    EXPECT_TRUE(own_host(host, "base.mine.example")) << host;
  for (const char* host :
       {"evil.example", "evil.example:7448", "127.0.0.1.evil.example:7448", "[evil.example]", "[::1", "1.2.3.4.5"})
    EXPECT_FALSE(own_host(host, "base.mine.example")) << host;
}

}  // namespace
}  // namespace headframe
