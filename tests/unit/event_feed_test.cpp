// The event feed over a real WebSocket.

#include <gtest/gtest.h>

#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

#include "server/cli/http_client.hpp"
#include "server/operator/event_feed.hpp"
#include "server/operator/event_queue.hpp"
#include "server/operator/http_rules.hpp"
#include "tests/support/operator_server.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
using Json = nlohmann::json;

/// A page that listens; every call blocks until it is done.
class Listener {
 public:
  explicit Listener(const OperatorServer& server) {
    socket_.next_layer().connect({net::ip::make_address("127.0.0.1"), server.api.port()});
    socket_.handshake(server.where(), "/api/v1/events", code_);
    EXPECT_FALSE(code_) << code_.message();
  }
  /// The next event that is no line of the log, or the next line; null when the connection has ended.
  Json next(bool of_log = false) {
    for (;;) {
      beast::flat_buffer buffer;
      socket_.read(buffer, code_);
      if (code_) return {};
      Json event = Json::parse(beast::buffers_to_string(buffer.data()));
      if ((event["type"] == "log") == of_log) return event;
    }
  }

 private:
  net::io_context io_;
  beast::websocket::stream<net::ip::tcp::socket> socket_{io_};
  boost::system::error_code code_;
};

/// The status line that asking for an upgrade is answered with.
std::string upgrade_status(const OperatorServer& server, const std::string& header = {}) {
  net::io_context io;
  net::ip::tcp::socket socket(io);
  socket.connect({net::ip::make_address("127.0.0.1"), server.api.port()});
  net::write(socket, net::buffer("GET /api/v1/events HTTP/1.1\r\nHost: " + server.where() +
                                 "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                                 header + "\r\n"));
  std::string answer;
  net::read_until(socket, net::dynamic_buffer(answer), "\r\n");
  return answer.substr(9, 3);
}

OperatorLimits quick(EventLimits events = {}) {
  events.look = std::chrono::milliseconds(1);
  OperatorLimits limits;
  limits.events = events;
  return limits;
}

TEST(EventFeed, ASnapshotThenWhatHappens) {
  OperatorServer server(quick());
  Listener first(server), second(server);
  for (Listener* listener : {&first, &second}) EXPECT_EQ(listener->next()["type"], "snapshot");
  server.station.change([&] { server.station.rows[0].connected = true; });
  for (Listener* listener : {&first, &second}) {
    const Json event = listener->next();
    EXPECT_EQ(event["type"], "robot_connected");
    EXPECT_EQ(event["robot"], "alpha");
  }
  server.station.change([&] { server.station.view.atlas.revision = 8; });
  EXPECT_EQ(first.next()["revision"], 8);
  Listener late(server);
  EXPECT_EQ(late.next()["atlas"]["revision"], 8);
}

TEST(EventFeed, TheLogIsToldAndCanBeReadLater) {
  OperatorServer server(quick());
  Listener listener(server);
  EXPECT_EQ(listener.next()["type"], "snapshot");
  server.station.change([&] { server.station.rows[0].connected = true; });
  EXPECT_EQ(listener.next(true)["entry"]["text"], "alpha/run/1 connected.");
  HttpClient client(*parse_http_endpoint(server.where()));
  ASSERT_EQ(client.post("/api/v1/alignments/1/retract")->status, 200);
  EXPECT_EQ(client.post("/api/v1/alignments/9/retract")->status, 404);
  const Json told = listener.next(true)["entry"];
  EXPECT_EQ(told["text"], "An operator took alpha/run/1 and beta/run/1 apart.");
  EXPECT_EQ(told["alignment_id"], 1);
  const Json entries = Json::parse(client.get("/api/v1/log?most=2")->body)["entries"];
  ASSERT_EQ(entries.size(), 2U) << "what was not done is not written down";
  EXPECT_EQ(entries[1], told);
  EXPECT_EQ(entries[0]["kind"], "connected");
}

TEST(EventFeed, WhatHappenedJustBeforeTheEndIsWrittenDownToo) {
  const TempDir folder;
  const auto file = folder.path() / "events.jsonl";
  {
    OperatorServer server({}, {.log = file});
    server.station.change([&] { server.station.rows[1].complete = true; });
  }
  EXPECT_EQ(EventLog(file).latest(1).at(0).text, "beta/run/1 finished: 3 keyframes.");
}

TEST(EventQueue, TooMuchIsReplacedByOneSnapshot) {
  const auto event = [](const char* text) { return std::make_shared<const std::string>(text); };
  const auto snapshot = [&] { return event("snapshot"); };
  EventQueue queue(10);
  queue.push(event("first"), snapshot);
  queue.push(event("tenth"), snapshot);
  EXPECT_EQ(queue.bytes(), 10U);
  EXPECT_EQ(*queue.pop(), "first");
  queue.push(event("second"), snapshot);
  EXPECT_EQ(*queue.pop(), "snapshot") << "11 bytes";
  EXPECT_EQ(queue.pop(), nullptr);
  EXPECT_EQ(queue.bytes(), 0U);
  queue.push(event("longer than the limit"), snapshot);
  EXPECT_EQ(*queue.pop(), "longer than the limit") << "one alone is not made smaller by a snapshot";
}

TEST(EventFeed, TurnsAwayWhatIsTooManyOrForeignOrNoWebSocket) {
  EventLimits one;
  one.clients = 1;
  OperatorServer server(quick(one));
  {
    Listener listener(server);
    EXPECT_EQ(listener.next()["type"], "snapshot");
    EXPECT_EQ(upgrade_status(server), "503");
  }
  EXPECT_EQ(upgrade_status(server, "Origin: http://elsewhere.example\r\n"), "403");
  const HttpResponse plain = *HttpClient(*parse_http_endpoint(server.where())).get("/api/v1/events");
  EXPECT_EQ(plain.status, 426);
}

TEST(EventFeed, APageShowsItsTokenAsAProtocol) {
  OperatorServer server(quick(), {.token = "0123abcd"});
  EXPECT_EQ(upgrade_status(server), "401");
  EXPECT_EQ(upgrade_status(server, "Sec-WebSocket-Protocol: headframe, 0123abce\r\n"), "401");
  EXPECT_EQ(upgrade_status(server, "Sec-WebSocket-Protocol: headframe, 0123abcd\r\n"), "101");
  EXPECT_EQ(upgrade_status(server, "Authorization: Bearer 0123abcd\r\n"), "101");
}

TEST(EventFeed, StoppingTheServerEndsTheListeners) {
  auto server = std::make_unique<OperatorServer>(quick());
  Listener listener(*server);
  EXPECT_EQ(listener.next()["type"], "snapshot");
  server.reset();
  EXPECT_TRUE(listener.next().is_null());
}

TEST(EventFeed, OriginsAreComparedWithTheHost) {
  EXPECT_TRUE(same_origin("", "mine:7448"));
  EXPECT_TRUE(same_origin("http://mine:7448", "mine:7448"));
  EXPECT_TRUE(same_origin("https://mine:7448", "mine:7448"));
  EXPECT_FALSE(same_origin("http://mine:7449", "mine:7448"));
  EXPECT_FALSE(same_origin("http://mine:7448.evil.example", "mine:7448"));
  EXPECT_FALSE(same_origin("null", "mine:7448"));
}

}  // namespace
}  // namespace headframe
