// The server's sockets, met by robots that are written byte by byte.
#include <gtest/gtest.h>

#include "server/cli/http_client.hpp"
#include "server/map_merge_server.hpp"
#include "server/store/sqlite.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

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

TEST_F(Connections, ARepeatIsAcknowledgedAndAnotherKeyframeOfItsNumberIsRefused) {
  serve();
  RawRobot robot(server->robots());
  robot.greet(robot_hello());
  for (int times = 0; times < 2; ++times) {
    robot.send(keyframe_frame(line_keyframe(1)));
    EXPECT_TRUE(robot.acknowledged(1));
  }
  Keyframe other = line_keyframe(1);
  other.T_local_sensor.translation().x() += 1;
  robot.send(keyframe_frame(other));
  const auto report = robot.error();
  EXPECT_EQ(report.kind(), v1::ERROR_KIND_REFUSED);
  EXPECT_NE(report.message().find("another pose"), std::string::npos) << report.message();
  RawRobot again(server->robots());
  EXPECT_EQ(again.greet(robot_hello()).durable_keyframes(), 1U);
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

TEST_F(Connections, DamageOnTheDiskCostsItselfAndNotTheExport) {
  serve();
  const std::string cloud = small_cloud();
  {
    RawRobot robot(server->robots());
    robot.greet(robot_hello());
    for (std::uint64_t i = 1; i <= 4; ++i)
      robot.send(keyframe_frame(line_keyframe(i)) + chunk_frame(i, cloud.size(), 0, cloud));
    int clouds = 0;
    EXPECT_TRUE(robot.read_until([&](const auto& m) { return (clouds += m.cloud_ack().sequences_size()) == 4; }));
  }
  server.reset();
  auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
  ASSERT_TRUE(database && database->execute("UPDATE clouds SET encoded=x'0102' WHERE sequence=2;"
                                            "UPDATE keyframes SET stamp_s=stamp_s+1 WHERE sequence=3"));
  serve();
  const auto map = HttpClient(HttpEndpoint{server->http()}).get("/api/v1/export?component=1&voxel=0");
  ASSERT_TRUE(map);
  EXPECT_EQ(map->status, 200);
  EXPECT_NE(map->body.find("element vertex 800\n"), std::string::npos) << map->body.substr(0, 300);
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
    EXPECT_NE(held->link_policy().hold().find("waits until it can write"), std::string::npos)
        << held->link_policy().hold();
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
  auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
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

}  // namespace
}  // namespace headframe
