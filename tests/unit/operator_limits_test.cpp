#include <gtest/gtest.h>

#include <chrono>
#include <future>

#include "tests/support/operator_server.hpp"
#include "tests/support/raw_client.hpp"

namespace headframe {
namespace {

std::string healthz(std::size_t header_bytes) {
  const std::string header = "GET /healthz HTTP/1.1\r\nHost: a\r\nConnection: close\r\nX: ";
  return header + std::string(header_bytes - header.size() - 4, 'x') + "\r\n\r\n";
}

std::string merge(std::size_t body_bytes) {
  return "POST /api/v1/merge HTTP/1.1\r\nHost: a\r\nConnection: close\r\nContent-Length: " +
         std::to_string(body_bytes) + "\r\n\r\n" + std::string(body_bytes, 'x');
}

TEST(OperatorLimits, HeadersUpToTheLimit) {
  OperatorServer server;
  for (const auto& [bytes, status] :
       {std::pair{8192U, "HTTP/1.1 200"}, {8193U, "HTTP/1.1 431"}, {300000U, "HTTP/1.1 431"}}) {
    RawClient client(server.api.port());
    client.send(healthz(bytes));
    EXPECT_EQ(status_of(client.rest()), status) << bytes;
    EXPECT_TRUE(client.ended_cleanly);
  }
  for (const std::string& endless : {"GET /" + std::string(8192, 'x'), std::string("GET / HTTP/1.1\r\n")}) {
    RawClient client(server.api.port());
    client.send(endless);
    for (int field = 0; field < 2000; ++field) client.send("X: y\r\n");  // each a segment of its own, mostly
    EXPECT_EQ(status_of(client.rest()), "HTTP/1.1 431");
  }
}

TEST(OperatorLimits, BodiesUpToTheLimit) {
  OperatorServer server;
  for (const auto& [bytes, status] :
       {std::pair{65536U, "HTTP/1.1 202"}, {65537U, "HTTP/1.1 413"}, {600000U, "HTTP/1.1 413"}}) {
    RawClient client(server.api.port());
    client.send(merge(bytes));
    EXPECT_EQ(status_of(client.rest()), status) << bytes;
    EXPECT_TRUE(client.ended_cleanly);
  }
  EXPECT_EQ(server.station.merges, 1);
}

TEST(OperatorLimits, RequestsOfAnAddressUpToTheLimit) {
  OperatorLimits limits;
  limits.requests = {.failures = 3, .forgiven_per_s = 1e-6, .addresses = 4};
  OperatorServer server(limits, {"right", nullptr});
  RawClient client(server.api.port());
  const auto ask = [&](const std::string& target) {
    client.send("GET " + target + " HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer right\r\n\r\n");
    return client.response();
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(status_of(ask("/api/v1/status")), "HTTP/1.1 200");
  const std::string refused = ask("/api/v1/status");
  EXPECT_EQ(status_of(refused), "HTTP/1.1 429");
  EXPECT_NE(refused.find("3 at once"), std::string::npos) << refused;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(status_of(ask("/healthz")), "HTTP/1.1 200") << "counted apart";
  EXPECT_EQ(status_of(ask("/healthz")), "HTTP/1.1 429");
}

TEST(OperatorLimits, AConnectionServesManyRequests) {
  OperatorServer server;
  RawClient client(server.api.port());
  for (const char* target : {"/healthz", "/api/v1/status", "/nothing", "/api/v1/atlas?wait=5"}) {
    client.send(std::string("GET ") + target + " HTTP/1.1\r\nHost: a\r\n\r\n");
    EXPECT_NE(client.response().find("Content-Type: application/json"), std::string::npos) << target;
  }
  client.send(
      "GET /api/v1/sessions/3/points HTTP/1.1\r\nHost: a\r\n\r\nGET /healthz HTTP/1.1\r\nHost: a\r\nConnection: "
      "close\r\n\r\n");
  const std::string both = client.rest();
  EXPECT_NE(both.find("Transfer-Encoding: chunked"), std::string::npos);
  EXPECT_NE(both.find("\r\n0\r\n\r\nHTTP/1.1 200 OK"), std::string::npos) << "a request after a streamed one";
}

TEST(OperatorLimits, GarbageGetsALineAndTheOthersGoOn) {
  OperatorServer server;
  for (const std::string& garbage : {std::string("\x16\x03\x01\x02\x00", 5) + "\r\n\r\n", std::string("GET\r\n\r\n"),
                                     std::string("GET /healthz HTTP/9.9\r\n\r\n"), std::string(500, '\0')}) {
    RawClient client(server.api.port());
    client.send(garbage);
    EXPECT_EQ(status_of(client.rest()), "HTTP/1.1 400");
  }
  RawClient half(server.api.port());
  half.send("GET /healthz HT");
  half.socket.shutdown(boost::asio::ip::tcp::socket::shutdown_send);
  EXPECT_EQ(half.rest(), "") << "nobody to answer";
  RawClient good(server.api.port());
  good.send(healthz(100));
  EXPECT_EQ(status_of(good.rest()), "HTTP/1.1 200");
}

TEST(OperatorLimits, StreamsAreForHttp11) {
  OperatorServer server;
  RawClient old(server.api.port());
  old.send("GET /api/v1/export?component=1 HTTP/1.0\r\n\r\n");
  EXPECT_EQ(status_of(old.rest()), "HTTP/1.1 505");
  RawClient check(server.api.port());
  check.send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_EQ(status_of(check.rest()), "HTTP/1.1 200");
}

TEST(OperatorLimits, TooManyConnectionsAreTold) {
  OperatorLimits limits;
  limits.connections = 1;
  OperatorServer server(limits);
  server.station.set_pending({1, 0, 0});
  auto served = std::make_unique<RawClient>(server.api.port());
  served->send("GET /api/v1/atlas?wait=3600 HTTP/1.1\r\nHost: a\r\n\r\n");
  while (server.station.waits == 0) std::this_thread::yield();
  RawClient second(server.api.port());
  second.send(healthz(100));
  const std::string refusal = second.rest();
  EXPECT_EQ(status_of(refusal), "HTTP/1.1 503");
  EXPECT_NE(refusal.find("too many connections"), std::string::npos);

  served.reset();  // the server sees the end of it in its own time
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < end) {
    RawClient next(server.api.port());
    next.send(healthz(100));
    if (status_of(next.rest()) == "HTTP/1.1 200") return;
  }
  FAIL() << "a connection that closed still counts";
}

TEST(OperatorLimits, WhoHoldsConnectionsWithoutTheTokenKeepsNobodyOut) {
  OperatorLimits limits;
  limits.connections = 3;
  OperatorServer server(limits, {"right", nullptr});
  const std::string with_token = "GET /api/v1/status HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer right\r\n\r\n";
  RawClient operators(server.api.port());
  operators.send(with_token);
  EXPECT_EQ(status_of(operators.response()), "HTTP/1.1 200");
  std::vector<std::unique_ptr<RawClient>> half_open;
  for (int i = 0; i < 8; ++i) {
    half_open.push_back(std::make_unique<RawClient>(server.api.port()));
    half_open.back()->send("GET / HTTP/1.1\r\n");
  }
  EXPECT_EQ(half_open.front()->rest(), "") << "the oldest made room";
  for (const auto& [header, status] : {std::pair(with_token, "HTTP/1.1 200"), {healthz(100), "HTTP/1.1 200"}}) {
    RawClient next(server.api.port());
    next.send(header);
    EXPECT_EQ(status_of(next.header()), status);
  }
  operators.send(with_token);
  EXPECT_EQ(status_of(operators.response()), "HTTP/1.1 200") << "who has shown the token is never sent away";
}

TEST(OperatorLimits, WhatTwoProgramsCouldReadDifferentlyIsRefused) {
  OperatorServer server;
  for (const char* fields :
       {"", "Host: a\r\nX: y\r\n z: w\r\n", "Host: a\r\nTransfer-Encoding: gzip\r\n", "Host: a\r\nHost: b\r\n"}) {
    RawClient client(server.api.port());
    client.send("POST /api/v1/merge HTTP/1.1\r\n" + std::string(fields) + "\r\n");
    EXPECT_EQ(status_of(client.rest()), "HTTP/1.1 400") << fields;
    EXPECT_TRUE(client.ended_cleanly);
  }
  EXPECT_EQ(server.station.merges, 0);
}

TEST(OperatorLimits, WithoutATokenAStrangersPageIsRefused) {
  OperatorServer open, asks({}, {"right", nullptr});
  const auto status_for = [](OperatorServer& server, const std::string& fields) {
    RawClient client(server.api.port());
    client.send("POST /api/v1/merge HTTP/1.1\r\nContent-Length: 0\r\n" + fields + "\r\n");
    return status_of(client.header());
  };
  EXPECT_EQ(status_for(open, "Host: evil.example:7448\r\n"), "HTTP/1.1 403") << "a name that was bound to this address";
  EXPECT_EQ(status_for(open, "Host: localhost\r\nOrigin: http://evil.example\r\n"), "HTTP/1.1 403");
  EXPECT_EQ(status_for(open, "Host: localhost\r\nOrigin: null\r\n"), "HTTP/1.1 403");
  EXPECT_EQ(open.station.merges, 0);
  EXPECT_EQ(status_for(open, "Host: localhost\r\nOrigin: http://localhost\r\n"), "HTTP/1.1 202");
  const std::string token = "Authorization: Bearer right\r\n";
  EXPECT_EQ(status_for(asks, token + "Host: base.mine.example\r\n"), "HTTP/1.1 202") << "the token says who asks";
}

TEST(OperatorLimits, AnswersMayNotBeFramedOrGuessedAt) {
  OperatorServer server;
  for (const char* target : {"/", "/healthz", "/nothing", "/api/v1/export?component=3"}) {
    RawClient client(server.api.port());
    client.send(std::string("GET ") + target + " HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
    const std::string header = client.header();
    EXPECT_NE(header.find("X-Content-Type-Options: nosniff\r\n"), std::string::npos) << target;
    EXPECT_NE(header.find("frame-ancestors 'none'\r\n"), std::string::npos) << target;
  }
}

TEST(OperatorLimits, AnIdleConnectionIsClosed) {
  OperatorLimits limits;
  limits.idle_s = 0.05;
  OperatorServer server(limits);
  RawClient silent(server.api.port());
  EXPECT_EQ(silent.rest(), "");
  RawClient slow(server.api.port());
  slow.send("GET /healthz HTTP/1.1\r\n");
  EXPECT_EQ(slow.rest(), "");
}

TEST(OperatorLimits, AClientThatReadsNothingIsDropped) {
  OperatorLimits limits;
  limits.write_s = 0.05;
  limits.connections = 1;
  OperatorServer server(limits);
  server.station.points = 2000000;  // 30 MB: more than the kernel's buffers take
  RawClient greedy(server.api.port());
  greedy.send("GET /api/v1/export?component=3&voxel=0 HTTP/1.1\r\nHost: a\r\n\r\n");
  for (int tries = 0; tries < 100000; ++tries) {
    RawClient next(server.api.port());
    next.send(healthz(100));
    if (status_of(next.rest()) == "HTTP/1.1 200") return;  // its place is free again
  }
  FAIL() << "it still holds its connection";
}

TEST(OperatorLimits, AWaitingClientThatLeavesFreesItsPlace) {
  OperatorLimits limits;
  limits.connections = 1;
  OperatorServer server(limits);
  server.station.set_pending({1, 0, 0});
  {
    RawClient waiting(server.api.port());
    waiting.send("GET /api/v1/atlas?wait=3600 HTTP/1.1\r\nHost: a\r\n\r\n");
    while (server.station.waits == 0) std::this_thread::yield();
  }
  // The server looks once a second whether who waits is still there; a fast machine tries 10000 times meanwhile.
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < deadline) {
    RawClient next(server.api.port());
    next.send(healthz(100));
    if (status_of(next.rest()) == "HTTP/1.1 200") return;
  }
  FAIL() << "it still holds its connection";
}

TEST(OperatorApi, StopEndsAWaitAndFreesThePort) {
  OperatorServer server;
  server.station.set_pending({1, 0, 0});
  RawClient waiting(server.api.port());
  waiting.send("GET /api/v1/atlas?wait=3600 HTTP/1.1\r\nHost: a\r\n\r\n");
  while (server.station.waits == 0) std::this_thread::yield();
  const std::uint16_t port = server.api.port();
  server.api.stop();
  EXPECT_EQ(waiting.rest(), "");
  server.api.stop();               // twice is harmless
  server.station.set_pending({});  // its callback finds nobody

  std::promise<void> closed;  // the port is closed on the acceptor's strand, in turn
  OperatorApi next(server.io, server.station);
  Result<void> open = next.listen("127.0.0.1", port);
  for (int tries = 0; tries < 10000 && !open; ++tries) open = next.listen("127.0.0.1", port);
  EXPECT_TRUE(open) << open.error().message;
}

TEST(OperatorApi, SaysWhyItCannotListen) {
  OperatorServer server;
  OperatorApi second(server.io, server.station);
  const auto in_use = second.listen("127.0.0.1", server.api.port());
  ASSERT_FALSE(in_use);
  EXPECT_EQ(in_use.error().code, ErrorCode::unavailable);
  EXPECT_NE(in_use.error().message.find("127.0.0.1:" + std::to_string(server.api.port()) + " is in use"),
            std::string::npos);
  for (const char* host : {"192.0.2.1", "no host", ""}) {
    const auto bad = second.listen(host, 0);
    ASSERT_FALSE(bad) << host;
    EXPECT_EQ(bad.error().code, ErrorCode::invalid_argument) << bad.error().message;
  }
  EXPECT_EQ(second.port(), 0);
  EXPECT_TRUE(second.listen("localhost", 0)) << "a failed listen may be repeated";
  EXPECT_NE(second.port(), 0);
}

}  // namespace
}  // namespace headframe
