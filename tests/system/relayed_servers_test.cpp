// Two servers on one PostgreSQL, and clients that know the one alone that stands by.
#include <csignal>

#include "tests/support/drawn_session.hpp"
#include "tests/support/plain_peer.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/servers_fixture.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

class RelayedServers : public Servers {
 protected:
  /// headframe with the address of the second server.
  Process::Ended ask_second(const std::vector<std::string>& words) const {
    std::vector<std::string> argv{program("headframe"), "--http", second->http()};
    if (!first->fingerprint().empty()) argv.insert(argv.end(), {"--token-file", second->token_file().string()});
    argv.insert(argv.end(), words.begin(), words.end());
    auto process = Process::start(argv);
    return process->wait(60s).value();
  }

  Json servers_by_second() const {
    const auto ended = ask_second({"servers", "--json"});
    return ended.status == 0 ? Json::parse(ended.output).at("servers") : Json::array();
  }

  bool second_relays() const { return ask_second({"status"}).status == 0; }

  /// Reads what the robot prints until these words come.
  static bool says(Process& robot, const std::string& words) {
    while (const auto line = robot.read_line(60s))
      if (line->find(words) != std::string::npos) return true;
    return false;
  }

  /// The status line of what the second server's operators' port answers to a client with this address.
  std::string status_line(const std::string& from, const std::string& token) const {
    PlainPeer client(parse_peer(second->http()).value(), from);
    client.send("GET /api/v1/status HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\nAuthorization: Bearer " +
                token + "\r\n\r\n");
    const std::string answer = client.rest();
    return answer.substr(0, answer.find('\r'));
  }

  void execute(const std::string& sql) const {
    auto psql = Process::start({(PostgresCluster::programs() / "psql").string(), url, "-c", sql});
    ASSERT_TRUE(psql);
    const auto ended = psql->wait(30s);
    ASSERT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
  }

  /// A robot that came to the second server and is acknowledged by the first.
  bool a_robot_gets_through(const std::string& name) const {
    RawRobot robot(*parse_peer(second->robots()));
    robot.send(hello_frame(robot_hello(name)));
    const auto answer = robot.read();
    if (!answer || !answer->has_welcome()) return false;
    robot.send(keyframe_frame(line_keyframe(1)));
    return robot.acknowledged(1);
  }
};

TEST_F(RelayedServers, RobotsOfBothServersAreMergedAndToldSo) {
  write_session(folder("a"), drive_a_to_c(1));
  write_session(folder("b"), drive_b_to_a(1));
  ASSERT_NO_FATAL_FAILURE(start_both(false));
  ASSERT_TRUE(until([&] { return second_relays(); }));
  auto a = drive("a", "50", {second->robots()}, "60"), b = drive("b", "50", {first->robots()}, "60");
  ASSERT_TRUE(a && b);
  EXPECT_TRUE(until([&] {
    const Json servers = servers_by_second();
    return servers.size() == 2 && servers[0]["self"] == true && servers[0]["relayed"] == 0 &&
           servers[1]["role"] == "standby" && servers[1]["relayed"] > 0;
  })) << "the active one answers, and lists who relays";
  EXPECT_TRUE(until([&] {
    EXPECT_EQ(ask_second({"merge"}).status, 0);
    const Json components = Json::parse(ask_second({"atlas", "--json"}).output).at("components");
    return components.size() == 1 && components[0].at("sessions").size() == 2;
  }));
  EXPECT_TRUE(says(*a, "T_mine_b")) << "through the server that stands by";
  EXPECT_TRUE(says(*b, "T_mine_a"));
}

TEST_F(RelayedServers, ARobotThatKnowsOnlyTheOneThatStandsByGoesOnWhenItTakesOver) {
  write_session(folder("a"), drive_a_to_c(1));
  ASSERT_NO_FATAL_FAILURE(start_both(false));
  ASSERT_TRUE(until([&] { return second_relays(); }));
  auto a = drive("a", "20", {second->robots()}, "0");
  ASSERT_TRUE(a);
  int stored = 0;
  ASSERT_TRUE(until([&] { return (stored = counts(*first)["a"].first) > 10; }));
  first->process().signal(SIGKILL);
  ASSERT_TRUE(first->process().wait(10s));
  const auto ready = second->await_ready();
  ASSERT_TRUE(ready) << ready.error().message;
  EXPECT_GE(counts(*second)["a"].first, stored) << "nothing was lost";
  expect_done(*a);

  auto calm = BaseStation::start(folder("calm"), "127.0.0.1:0", true);
  ASSERT_TRUE(calm) << calm.error().message;
  auto alone = calm->replay("a", folder("a"));
  ASSERT_TRUE(alone);
  expect_done(*alone);
  EXPECT_EQ(counts(*calm), counts(*second)) << "the same as without relay and kill";
}

TEST_F(RelayedServers, WrongTokensOfOneClientLockNoOtherOut) {
  ASSERT_NO_FATAL_FAILURE(start_both(false));
  ASSERT_TRUE(until([&] { return second_relays(); }));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(status_line("127.0.0.2", "wrong"), "HTTP/1.1 401 Unauthorized");
  EXPECT_EQ(status_line("127.0.0.2", "wrong"), "HTTP/1.1 429 Too Many Requests");
  EXPECT_EQ(status_line("127.0.0.3", "wrong"), "HTTP/1.1 401 Unauthorized");
  EXPECT_EQ(status_line("127.0.0.2", first->token().value()), "HTTP/1.1 200 OK") << "a token that fits always does";
}

TEST_F(RelayedServers, AFloodKeepsNobodyOut) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  ASSERT_TRUE(until([&] { return second_relays(); }));
  std::vector<std::unique_ptr<PlainPeer>> flood;
  for (int i = 0; i < 600; ++i) {
    flood.push_back(std::make_unique<PlainPeer>(*parse_peer(second->robots())));
    if (i % 2 == 0) flood.back()->send(std::string(1, '\0'));
  }
  EXPECT_TRUE(a_robot_gets_through("ant"));
  flood.clear();
  EXPECT_TRUE(until([&] {
    const Json servers = servers_by_second();
    return servers.size() == 2 && servers[1]["relayed"] < 10;
  })) << "what has ended is forgotten";
  EXPECT_EQ(second->process().poll(), -1);
}

/// As beside an active server of an older version, which would take the header for a fault of the robot's.
TEST_F(RelayedServers, WithTheSchemaOfAnOlderServerItIsListedAndTurnsAway) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  ASSERT_TRUE(until([&] { return lists_a_standby(*first) && a_robot_gets_through("ant"); }));
  execute("ALTER TABLE headframe.servers DROP COLUMN relayed, DROP COLUMN loopback");
  EXPECT_TRUE(until([&] { return !second_relays(); }));
  EXPECT_FALSE(a_robot_gets_through("bee"));
  EXPECT_TRUE(until([&] { return lists_a_standby(*first); }));
  execute(
      "ALTER TABLE headframe.servers ADD COLUMN relayed BIGINT NOT NULL DEFAULT 0,"
      " ADD COLUMN loopback TEXT NOT NULL DEFAULT ''");
  EXPECT_TRUE(until([&] { return a_robot_gets_through("cat"); }));
}

}  // namespace
}  // namespace headframe::test
