// What the active server makes of the header of one that stands by, at its two doors.
#include "server/map_merge_server.hpp"
#include "server/security/operator_guard.hpp"
#include "server/security/relay_header.hpp"
#include "tests/support/plain_peer.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/support/tls_peer.hpp"

namespace headframe {
namespace {

using boost::asio::ip::make_address;
using boost::asio::ip::tcp;

class RelayedPeer : public testing::Test {
 protected:
  void serve(OperatorTls tls = OperatorTls::beyond_loopback, bool insecure = false) {
    ServerConfig config;
    config.operators.tls = tls;
    config.limits.hello_s = 600;
    auto started = MapMergeServer::start({dir.path(), {"127.0.0.1", 0}, {"127.0.0.1", 0}, config, insecure});
    ASSERT_TRUE(started) << started.error().message;
    server = std::move(*started);
    token = insecure ? "" : operator_token(dir.path()).value();
  }

  std::string header(const std::string& client) const {
    return relay_header(tcp::endpoint(make_address(client), 40000), tcp::endpoint(make_address("192.0.2.1"), 7447),
                        relay_key(token));
  }
  std::string request(const std::string& shown) const {
    return "GET /api/v1/status HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\nAuthorization: Bearer " + shown +
           "\r\n\r\n";
  }
  static std::string status_of(const std::string& answer) { return answer.substr(0, answer.find('\r')); }

  std::string ask(const std::string& before, const std::string& shown) const {
    PlainPeer peer(server->http());
    peer.send(before + request(shown));
    return status_of(peer.rest());
  }

  /// What a robot with a token that fits nobody is told.
  std::string refusal(const std::string& before) const {
    test::TlsPeer robot({server->robots(), "", "", "", ""}, before);
    Hello hello = robot_hello();
    hello.token = random_secret(token_bytes);
    robot.send(hello_frame(hello));
    return robot.until_closed();
  }

  TempDir dir;
  std::unique_ptr<MapMergeServer> server;
  std::string token;
};

TEST_F(RelayedPeer, AnOperatorsWrongTokensCountForTheAddressInTheHeader) {
  serve();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(ask(header("203.0.113.7"), "wrong"), "HTTP/1.1 401 Unauthorized");
  EXPECT_EQ(ask(header("203.0.113.7"), "wrong"), "HTTP/1.1 429 Too Many Requests");
  EXPECT_EQ(ask(header("203.0.113.8"), "wrong"), "HTTP/1.1 401 Unauthorized");
  EXPECT_EQ(ask("", "wrong"), "HTTP/1.1 401 Unauthorized") << "nor is the relay itself locked out";
  EXPECT_EQ(ask(header("203.0.113.7"), token), "HTTP/1.1 200 OK");
}

TEST_F(RelayedPeer, ARobotsWrongTokensCountForTheAddressInTheHeader) {
  serve();
  const std::string stranger = refusal("");
  ASSERT_NE(stranger, "");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(refusal(header("203.0.113.7")), stranger);
  EXPECT_EQ(refusal(header("203.0.113.7")), "too many failed attempts from 203.0.113.7: try again in a minute");
  EXPECT_EQ(refusal(header("203.0.113.8")), stranger);
  EXPECT_EQ(refusal(""), stranger) << "nor is the relay itself locked out";
}

TEST_F(RelayedPeer, TlsGoesOnBehindTheHeader) {
  serve(OperatorTls::always);
  test::TlsPeer browser({server->http(), "", "", "", ""}, header("203.0.113.7"));
  browser.send(request(token));
  EXPECT_EQ(status_of(browser.rest()), "HTTP/1.1 200 OK");
  test::TlsPeer direct({server->http(), "", "", "", ""});
  direct.send(request(token));
  EXPECT_EQ(status_of(direct.rest()), "HTTP/1.1 200 OK");
}

TEST_F(RelayedPeer, WithoutTokensARelayWorksToo) {
  serve(OperatorTls::beyond_loopback, true);
  RawRobot robot(server->robots());
  robot.send(header("203.0.113.7"));
  robot.greet(robot_hello());
  robot.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(robot.acknowledged(1));
  EXPECT_EQ(ask(header("203.0.113.7"), ""), "HTTP/1.1 200 OK");
}

TEST_F(RelayedPeer, WhatIsNoHeaderOfThisBaseStationEndsTheConnectionAndNothingElse) {
  serve();
  const auto of_key = [](const std::string& key) {
    return relay_header(tcp::endpoint(make_address("203.0.113.7"), 1), tcp::endpoint(make_address("192.0.2.1"), 2),
                        relay_key(key));
  };
  const std::string good = header("203.0.113.7");
  const std::vector<std::string> bad{of_key(""), of_key("other"), "\r\n\r\n" + std::string(5000, 'x'),
                                     good.substr(0, 12) + std::string(100, '\xff')};
  for (const Endpoint& door : {server->robots(), server->http()}) {
    for (const std::string& bytes : bad) {
      PlainPeer peer(door);
      peer.send(bytes);
      EXPECT_TRUE(peer.is_turned_away()) << "header " << to_hex(bytes.substr(0, 40));
    }
    for (std::size_t bytes = 1; bytes < good.size(); ++bytes) {
      PlainPeer peer(door);
      peer.send(good.substr(0, bytes));
      peer.end_sending();
      EXPECT_TRUE(peer.is_turned_away()) << bytes << " bytes of a header";
    }
  }
  EXPECT_EQ(ask(good, token), "HTTP/1.1 200 OK");
  EXPECT_NE(refusal(good), "");
}

/// It does not hold a place for as long as it likes.
TEST_F(RelayedPeer, AHeaderThatStopsInTheMiddleIsNotWaitedForLong) {
  serve();
  PlainPeer robot(server->robots()), browser(server->http());
  robot.send(header("203.0.113.7").substr(0, 20));
  browser.send(header("203.0.113.7").substr(0, 20));
  EXPECT_TRUE(robot.is_turned_away());
  EXPECT_TRUE(browser.is_turned_away());
}

TEST_F(RelayedPeer, AHeaderAfterAHeaderIsNone) {
  serve();
  const std::string twice = header("203.0.113.7") + header("203.0.113.8");
  EXPECT_NE(ask(twice, token), "HTTP/1.1 200 OK");
  PlainPeer robot(server->robots());
  robot.send(twice);
  robot.end_sending();
  (void)robot.rest();  // it is told, in the clear, that this port takes TLS
  EXPECT_EQ(ask("", token), "HTTP/1.1 200 OK");
}

}  // namespace
}  // namespace headframe
