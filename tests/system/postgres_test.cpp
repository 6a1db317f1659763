// A base station over PostgreSQL that goes away: what robots, operators and the one who starts it notice.
#include <gtest/gtest.h>

#include <fstream>

#include "server/map_merge_server.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/postgres_fixture.hpp"
#include "tests/support/raw_robot.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

class OverPostgres : public PostgresFixture {
 protected:
  Result<Process> start_server(const std::string& data, const std::string& of_url) {
    const std::string config = (scratch.path() / (data + ".toml")).string();
    std::ofstream(config) << "[store]\nurl = \"" << of_url << "\"\n";
    return Process::start({program("headframe-server"), "--data", (scratch.path() / data).string(), "--listen",
                           "127.0.0.1:0", "--http", "127.0.0.1:0", "--insecure", "--config", config});
  }

  /// What it printed until a line has `words`.
  static std::string read_until(Process& server, const std::string& words) {
    std::string all;
    while (true) {
      const auto line = server.read_line(30s);
      if (!line) return all + line.error().message;
      all += *line + "\n";
      if (line->find(words) != std::string::npos) return all;
    }
  }
};

TEST_F(OverPostgres, RobotsAreHeldWhileTheDatabaseIsAwayAndGoOnByThemselves) {
  ServerConfig config;
  config.store_url = url;
  const auto server = MapMergeServer::start({scratch.path(), {"127.0.0.1", 0}, {"127.0.0.1", 0}, config, true});
  ASSERT_TRUE(server) << server.error().message;
  RawRobot robot((*server)->robots());
  robot.greet(robot_hello());
  robot.send(keyframe_frame(line_keyframe(1)));
  ASSERT_TRUE(robot.acknowledged(1));
  cluster->kill();
  for (std::uint64_t i = 2; i <= 10; ++i) robot.send(keyframe_frame(line_keyframe(i)));
  bool acknowledged = false;
  const auto held = robot.read_until([&](const auto& m) {
    acknowledged |= m.has_keyframe_ack() && m.keyframe_ack().durable_keyframes() > 1;
    return m.has_error() || !m.link_policy().hold().empty();
  });
  ASSERT_TRUE(held && held->has_link_policy()) << "the link stays";
  EXPECT_NE(held->link_policy().hold().find("PostgreSQL, database mine1"), std::string::npos)
      << held->link_policy().hold();
  RawRobot other((*server)->robots());
  other.send(hello_frame(robot_hello("bee")));
  EXPECT_TRUE(other.read_until([](const auto& m) { return !m.link_policy().hold().empty(); })) << "told, not ended";
  EXPECT_FALSE(acknowledged);
  ASSERT_TRUE(cluster->start());
  bool released = false;
  EXPECT_TRUE(robot.read_until([&](const auto& m) {
    released |= m.has_link_policy() && m.link_policy().hold().empty();
    acknowledged |= m.has_keyframe_ack() && m.keyframe_ack().durable_keyframes() == 10;
    return released && acknowledged;
  }));
}

TEST_F(OverPostgres, AServerWaitsForItsDatabaseAtTheStartAndASecondOneIsTurnedAway) {
  cluster->kill();
  auto first = start_server("first", url);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_NE(read_until(*first, "waiting for the database").find("waiting for the database: PostgreSQL, database mine1"),
            std::string::npos);
  ASSERT_TRUE(cluster->start());
  EXPECT_NE(read_until(*first, "headframe-server ready").find("headframe-server ready"), std::string::npos);
  auto second = start_server("second", url);
  ASSERT_TRUE(second) << second.error().message;
  const auto refused = second->wait(30s);
  ASSERT_TRUE(refused) << refused.error().message;
  EXPECT_EQ(refused->status, 1);
  EXPECT_NE(refused->output.find("is in use by another headframe-server"), std::string::npos) << refused->output;
  first->signal(SIGKILL);
  (void)first->wait(10s);
  auto after = start_server("first", url);
  ASSERT_TRUE(after);
  EXPECT_NE(read_until(*after, "headframe-server ready").find("ready"), std::string::npos) << "the lock died with it";
  auto wrong = start_server("wrong", cluster->url("absent"));
  ASSERT_TRUE(wrong);
  const auto absent = wrong->wait(30s);
  ASSERT_TRUE(absent);
  EXPECT_EQ(absent->status, 1);
  EXPECT_NE(absent->output.find("database \"absent\" does not exist"), std::string::npos) << absent->output;
}

TEST(RobotLibrary, NeedsNoneOfTheServersDatabases) {
  auto ldd = Process::start({"/usr/bin/ldd", program("headframe-replay")});
  ASSERT_TRUE(ldd) << ldd.error().message;
  const auto ended = ldd->wait(30s);
  ASSERT_TRUE(ended && ended->status == 0);
  EXPECT_EQ(ended->output.find("libpq"), std::string::npos) << ended->output;
  EXPECT_EQ(ended->output.find("libsqlite3"), std::string::npos) << ended->output;
}

}  // namespace
}  // namespace headframe::test
