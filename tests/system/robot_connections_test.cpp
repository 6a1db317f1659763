// The server's sockets, met by robots that are written byte by byte.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <csignal>

#include "server/map_merge_server.hpp"
#include "server/store/sqlite.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

/// Waits at most ten seconds for each message.
class RawRobot {
 public:
  explicit RawRobot(const Endpoint& server) {
    boost::asio::ip::tcp::resolver resolver(io_);
    boost::asio::connect(socket_, resolver.resolve(server.host, std::to_string(server.port)));
    const timeval patience{10, 0};
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }

  void send(const std::string& bytes) {
    boost::system::error_code ignored;  // the server may have closed: read() tells
    boost::asio::write(socket_, boost::asio::buffer(bytes), ignored);
  }

  /// nullopt: the server has closed the connection, or is silent.
  std::optional<v1::ServerMessage> read() {
    while (true) {
      const auto payload = reader_.next();
      if (payload && *payload) {
        v1::ServerMessage message;
        EXPECT_TRUE(message.ParseFromString(**payload));
        return message;
      }
      char bytes[4096];
      const auto n = ::recv(socket_.native_handle(), bytes, sizeof bytes, 0);
      if (n <= 0) return std::nullopt;
      reader_.feed({bytes, static_cast<std::size_t>(n)});
    }
  }

  /// The next message for which it holds.
  template <class Condition>
  std::optional<v1::ServerMessage> read_until(Condition condition) {
    while (auto message = read())
      if (condition(*message)) return message;
    return std::nullopt;
  }

  v1::Welcome greet(const Hello& hello) {
    send(hello_frame(hello));
    const auto message = read_until([](const auto& m) { return m.has_welcome() || m.has_error(); });
    EXPECT_TRUE(message && message->has_welcome()) << (message ? message->error().message() : "silence");
    return message ? message->welcome() : v1::Welcome();
  }

  v1::ErrorReport error() {
    const auto message = read_until([](const auto& m) { return m.has_error(); });
    EXPECT_TRUE(message);
    EXPECT_FALSE(read()) << "the connection ends with its error";
    return message ? message->error() : v1::ErrorReport();
  }

  bool acknowledged(std::uint64_t keyframe) {
    return read_until(
               [=](const auto& m) { return m.has_keyframe_ack() && m.keyframe_ack().durable_keyframes() >= keyframe; })
        .has_value();
  }

 private:
  boost::asio::io_context io_;
  boost::asio::ip::tcp::socket socket_{io_};
  FrameReader reader_;
};

/// Of a robot that hardly moves: thousands of them make no map that is worth an attempt to merge.
std::string slow_keyframe(std::uint64_t sequence) { return keyframe_frame(line_keyframe(sequence, 0.001)); }

class Connections : public testing::Test {
 protected:
  void serve(const ServerConfig& config = {}) {
    server.reset();
    auto started = MapMergeServer::start({dir.path(), {"127.0.0.1", 0}, {"127.0.0.1", 0}, config, true});
    ASSERT_TRUE(started) << started.error().message;
    server = std::move(*started);
  }

  TempDir dir;
  std::unique_ptr<MapMergeServer> server;
};

TEST_F(Connections, WhatIsAcknowledgedOutlivesTheServer) {
  serve();
  {
    RawRobot robot(server->robots());
    EXPECT_EQ(robot.greet(robot_hello()).durable_keyframes(), 0U);
    for (std::uint64_t i = 1; i <= 20; ++i) robot.send(keyframe_frame(line_keyframe(i)));
    const std::string cloud = small_cloud();
    robot.send(chunk_frame(3, cloud.size(), 0, cloud));
    EXPECT_TRUE(robot.acknowledged(20));
    EXPECT_TRUE(robot.read_until([](const auto& m) { return m.has_cloud_ack() && m.cloud_ack().sequences(0) == 3; }));
  }
  serve();
  RawRobot robot(server->robots());
  const auto welcome = robot.greet(robot_hello());
  EXPECT_EQ(welcome.durable_keyframes(), 20U);
  ASSERT_EQ(welcome.durable_clouds_size(), 1);
  EXPECT_EQ(welcome.durable_clouds(0).first(), 3U);
}

TEST_F(Connections, ADamagedCloudIsRefusedAndTheRobotGoesOn) {
  serve();
  RawRobot robot(server->robots());
  robot.greet(robot_hello());
  const std::string cloud = small_cloud();
  robot.send(keyframe_frame(line_keyframe(1)) + chunk_frame(1, 7, 0, "garbage"));
  EXPECT_TRUE(robot.read_until([](const auto& m) { return m.cloud_refusal().sequence() == 1; }));
  robot.send(keyframe_frame(line_keyframe(2)) + chunk_frame(2, cloud.size(), 0, cloud));
  EXPECT_TRUE(robot.read_until([](const auto& m) { return m.has_cloud_ack() && m.cloud_ack().sequences(0) == 2; }));
}

TEST_F(Connections, AnotherSpoolIsRefusedAndTheSameReplaces) {
  serve();
  RawRobot first(server->robots());
  first.greet(robot_hello());
  Hello stranger = robot_hello();
  stranger.spool_id = 78;
  RawRobot other(server->robots());
  other.send(hello_frame(stranger));
  const auto refused = other.error();
  EXPECT_EQ(refused.kind(), v1::ERROR_KIND_REFUSED);
  EXPECT_TRUE(refused.permanent());

  first.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(first.acknowledged(1)) << "the stranger did not disturb it";
  RawRobot second(server->robots());
  EXPECT_EQ(second.greet(robot_hello()).durable_keyframes(), 1U);
  EXPECT_FALSE(first.error().permanent());
  second.send(keyframe_frame(line_keyframe(2)));
  EXPECT_TRUE(second.acknowledged(2));
}

TEST_F(Connections, AnotherFamilyIsRefused) {
  serve();
  RawRobot(server->robots()).greet(robot_hello());
  Hello changed = robot_hello();
  changed.family.q_size = 4;
  RawRobot robot(server->robots());
  robot.send(hello_frame(changed));
  EXPECT_EQ(robot.error().kind(), v1::ERROR_KIND_REFUSED);
}

TEST_F(Connections, TooManyRobotsAreToldSo) {
  ServerConfig config;
  config.limits.robots = 1;
  serve(config);
  RawRobot first(server->robots());
  first.greet(robot_hello());
  RawRobot second(server->robots());
  second.send(hello_frame(robot_hello("bee")));
  const auto report = second.error();
  EXPECT_EQ(report.kind(), v1::ERROR_KIND_OVERLOADED);
  EXPECT_FALSE(report.permanent());
  first.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(first.acknowledged(1));
}

TEST_F(Connections, StrangersWhoHoldConnectionsKeepNobodyOut) {
  ServerConfig config;
  config.limits.strangers = 2;
  serve(config);
  RawRobot known(server->robots());
  known.greet(robot_hello());
  RawRobot first(server->robots()), second(server->robots()), third(server->robots());
  EXPECT_FALSE(first.read()) << "the oldest made room";
  third.greet(robot_hello("bee"));
  second.greet(robot_hello("wasp"));
  known.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(known.acknowledged(1)) << "who was let in is no stranger";
}

TEST_F(Connections, ACopyOfASpoolIsRefusedWhoeverGoesOnFirst) {
  serve();
  const auto with_runs = [](std::vector<std::uint64_t> runs) {
    Hello hello = robot_hello();
    hello.spool_runs = std::move(runs);
    return hello;
  };
  RawRobot(server->robots()).greet(with_runs({10}));
  RawRobot original(server->robots());
  original.greet(with_runs({10, 11}));
  const auto expect_clone_refused = [&](const Hello& clone) {
    RawRobot robot(server->robots());
    robot.send(hello_frame(clone));
    const auto report = robot.error();
    EXPECT_TRUE(report.permanent());
    EXPECT_NE(report.message().find("clone"), std::string::npos) << report.message();
  };
  expect_clone_refused(with_runs({10, 12}));
  original.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(original.acknowledged(1)) << "the clone did not disturb it";
  serve();  // what was decided outlives the server
  expect_clone_refused(with_runs({10, 12}));
  RawRobot again(server->robots());
  EXPECT_EQ(again.greet(with_runs({10, 11, 13, 14})).durable_keyframes(), 1U) << "restarted twice without a link";
}

/// Files of this process may not grow beyond this: a full disk that can be emptied.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
};

TEST_F(Connections, AFullDiskHoldsTheRobotAndItGoesOnByItself) {
  serve();
  RawRobot robot(server->robots());
  robot.greet(robot_hello());
  constexpr std::uint64_t all = 3000;
  {
    const FileLimit limit(1'000'000);
    for (std::uint64_t i = 1; i <= all; ++i) robot.send(slow_keyframe(i));
    const auto held = robot.read_until([](const auto& m) { return m.has_error() || !m.link_policy().hold().empty(); });
    ASSERT_TRUE(held && held->has_link_policy()) << "the link stays";
    EXPECT_NE(held->link_policy().hold().find("waits for its disk"), std::string::npos) << held->link_policy().hold();
    v1::RobotMessage ping;
    ping.mutable_ping()->set_nonce(5);
    robot.send(frame(ping));
    EXPECT_TRUE(robot.read_until([](const auto& m) { return m.pong().nonce() == 5; })) << "it is still served";
    RawRobot other(server->robots());
    EXPECT_EQ(other.greet(robot_hello("bee")).durable_keyframes(), 0U) << "others are welcomed, and told why not";
    EXPECT_TRUE(other.read_until([](const auto& m) { return !m.link_policy().hold().empty(); }));
  }
  bool released = false, acknowledged = false;  // in either order
  EXPECT_TRUE(robot.read_until([&](const auto& m) {
    released |= m.has_link_policy() && m.link_policy().hold().empty();
    acknowledged |= m.keyframe_ack().durable_keyframes() == all;
    return released && acknowledged;
  }));
}

TEST_F(Connections, ABrokenDatabaseAcknowledgesNothingAndSaysWhy) {
  serve();
  RawRobot robot(server->robots());
  robot.greet(robot_hello());
  robot.send(keyframe_frame(line_keyframe(1)));
  ASSERT_TRUE(robot.acknowledged(1));
  auto database = Database::open((dir.path() / "headframe.db").string());
  ASSERT_TRUE(database && database->execute("ALTER TABLE keyframes RENAME TO elsewhere"));
  robot.send(keyframe_frame(line_keyframe(2)));
  const auto held = robot.read_until([](const auto& m) { return m.has_error() || m.has_link_policy(); });
  ASSERT_TRUE(held && held->has_link_policy()) << "the link stays";
  EXPECT_NE(held->link_policy().hold().find("no such table"), std::string::npos) << held->link_policy().hold();
  RawRobot other(server->robots());
  other.send(hello_frame(robot_hello("bee")));
  EXPECT_TRUE(other.read_until([](const auto& m) { return !m.link_policy().hold().empty(); })) << "told, not ended";
  robot.send(keyframe_frame(line_keyframe(3)));
  v1::RobotMessage ping;
  ping.mutable_ping()->set_nonce(5);
  robot.send(frame(ping));
  EXPECT_TRUE(robot.read_until([](const auto& m) {
    EXPECT_FALSE(m.has_keyframe_ack());
    return m.pong().nonce() == 5;
  })) << "it is still served";
  ASSERT_TRUE(database->execute("ALTER TABLE elsewhere RENAME TO keyframes"));
  serve();
  RawRobot again(server->robots());
  EXPECT_EQ(again.greet(robot_hello()).durable_keyframes(), 1U);
  again.send(keyframe_frame(line_keyframe(2)));
  EXPECT_TRUE(again.acknowledged(2));
}

TEST_F(Connections, ADatabaseAtItsLimitLosesNothingThatWasAcknowledged) {
  ServerConfig config;
  config.database_mib = 1;
  serve(config);
  std::uint64_t acknowledged = 0, sent = 0;
  {
    RawRobot robot(server->robots());
    robot.greet(robot_hello());
    for (bool held = false; !held && sent < 5000;) {
      for (int i = 0; i < 50; ++i) robot.send(slow_keyframe(++sent));
      const auto message = robot.read_until(
          [&](const auto& m) { return m.has_link_policy() || m.keyframe_ack().durable_keyframes() == sent; });
      ASSERT_TRUE(message);
      held = message->has_link_policy();
      if (!held) acknowledged = sent;
    }
  }
  EXPECT_LT(sent, 5000U);
  serve();  // with a larger limit
  RawRobot later(server->robots());
  const auto durable = later.greet(robot_hello()).durable_keyframes();
  EXPECT_GE(durable, acknowledged);
  later.send(keyframe_frame(line_keyframe(durable + 1)));
  EXPECT_TRUE(later.acknowledged(durable + 1));
}

TEST_F(Connections, TheBudgetIsSharedByThoseWhoAreThere) {
  ServerConfig config;
  config.limits.uplink_kib_s = 10;
  serve(config);
  const auto told = [](std::uint64_t bytes_per_s) {
    return [=](const auto& m) { return m.has_link_policy() && m.link_policy().bytes_per_s() == bytes_per_s; };
  };
  RawRobot first(server->robots());
  first.greet(robot_hello("ant"));
  EXPECT_TRUE(first.read_until(told(10240)));
  {
    RawRobot second(server->robots());
    second.greet(robot_hello("bee"));
    EXPECT_TRUE(first.read_until(told(5120)));
    EXPECT_TRUE(second.read_until(told(5120)));
  }
  EXPECT_TRUE(first.read_until(told(10240)));
}

TEST_F(Connections, ARobotThatOutrunsTheDiskIsHeldBackAndAllArrives) {
  ServerConfig config;
  config.limits.undurable_mib = 1;
  serve(config);
  RawRobot robot(server->robots());
  robot.greet(robot_hello());
  for (std::uint64_t i = 1; i <= 5000; ++i) robot.send(slow_keyframe(i));
  EXPECT_TRUE(robot.acknowledged(5000));
}

TEST_F(Connections, APortInUseIsSaid) {
  serve();
  const TempDir elsewhere;
  const auto second = MapMergeServer::start({elsewhere.path(), server->robots(), {"127.0.0.1", 0}, {}, true});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::unavailable);
  EXPECT_NE(second.error().message.find(to_string(server->robots())), std::string::npos);
}

TEST(Endpoint, IsReadAsItIsWritten) {
  for (const std::string text : {"127.0.0.1:7447", "[::1]:0", "base.mine:65535"})
    EXPECT_EQ(to_string(parse_endpoint(text).value()), text);
  for (const std::string text : {"", ":1", "host", "host:", "host:65536", "host:-1", "host:1x", "::1:80", "[]:1"})
    EXPECT_FALSE(parse_endpoint(text)) << text;
}

}  // namespace
}  // namespace headframe
