// Two servers on one PostgreSQL: one serves, the other waits, and takes over when the first is lost.
#include <gtest/gtest.h>

#include <array>
#include <csignal>
#include <set>

#include "tests/support/drawn_session.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/servers_fixture.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
namespace fs = std::filesystem;

TEST_F(Servers, OneIsKilledInTheMiddleOfADriveAndTheOtherGoesOn) {
  write_session(folder("a"), drive_a_to_c(1));
  write_session(folder("b"), drive_b_to_a(1));
  ASSERT_NO_FATAL_FAILURE(start_both(false));
  EXPECT_TRUE(until([&] { return lists_a_standby(*first); }));
  auto a = drive("a", "20"), b = drive("b", "20");
  ASSERT_TRUE(a && b);
  std::map<std::string, std::pair<int, int>> before;
  ASSERT_TRUE(until([&] {
    before = counts(*first);
    return before["a"].first > 10 && before["b"].first > 10;
  }));
  first->process().signal(SIGKILL);
  ASSERT_TRUE(first->process().wait(10s));
  const auto ready = second->await_ready();
  ASSERT_TRUE(ready) << ready.error().message;
  EXPECT_EQ(second->fingerprint(), first->fingerprint());
  ASSERT_TRUE(until([&] { return rows(*second, "servers").at(0).at("self") == true; }));
  EXPECT_FALSE(lists_a_standby(*second)) << "the one that was killed does not wait for anything";
  const auto then = counts(*second);
  for (const auto& [robot, stored] : before) EXPECT_GE(then.at(robot).first, stored.first) << "nothing was lost";
  auto again = BaseStation::start_standby(folder("first"), config());  // as a service manager would
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(until([&] { return lists_a_standby(*second); }));
  expect_done(*a);
  expect_done(*b);
  const auto atlas = second->settled_atlas();
  ASSERT_TRUE(atlas) << atlas.error().message;
  EXPECT_EQ(atlas->at("components").size(), 1U);

  auto calm = BaseStation::start(folder("calm"), "127.0.0.1:0", true);
  ASSERT_TRUE(calm) << calm.error().message;
  for (const char* robot : {"a", "b"}) {
    auto alone = calm->replay(robot, folder(robot));
    ASSERT_TRUE(alone);
    expect_done(*alone);
  }
  EXPECT_EQ(counts(*calm), counts(*second)) << "the same as without any kill";
}

/// The sessions of each component, by robot.
std::set<std::set<std::string>> together(const BaseStation& station) {
  std::set<std::set<std::string>> out;
  const auto atlas = station.settled_atlas();
  EXPECT_TRUE(atlas) << atlas.error().message;
  if (!atlas) return out;
  for (const Json& component : atlas->at("components")) {
    std::set<std::string> robots;
    for (const Json& session : component.at("sessions")) robots.insert(session.at("robot"));
    out.insert(robots);
  }
  return out;
}

TEST_F(Servers, TheOneThatStandsBySearchesPairsAndTheMapIsTheSame) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  ASSERT_TRUE(until([&] { return lists_a_standby(*first); }));
  const std::array drives{drive_a_to_c(), drive_b_to_a(), drive_d_to_b()};
  std::vector<std::string> robots;
  const auto one_more = [&](const BaseStation& station, const std::string& robot) {
    auto replay = station.replay(robot, folder(robot));
    ASSERT_TRUE(replay) << replay.error().message;
    expect_done(*replay);
  };
  const auto searched = [&] {
    const Json servers = rows(*first, "servers");
    return servers.size() == 2 ? servers[1].at("searched").get<int>() : 0;
  };
  while (robots.size() < 3 || (searched() == 0 && robots.size() < 12)) {  // it may not get to one before they are done
    robots.push_back("robot" + std::to_string(robots.size()));
    write_session(folder(robots.back()), drives.at(robots.size() % drives.size()));
    one_more(*first, robots.back());
  }
  EXPECT_TRUE(until([&] { return searched() > 0; }));
  second->process().signal(SIGKILL);  // whatever it is searching, the active one ends the attempt without it
  robots.push_back("last");
  write_session(folder("last"), drives[0]);
  one_more(*first, "last");
  const auto with_help = together(*first);
  auto calm = BaseStation::start(folder("calm"), "127.0.0.1:0", true);
  ASSERT_TRUE(calm) << calm.error().message;
  for (const std::string& robot : robots) one_more(*calm, robot);
  EXPECT_EQ(with_help, together(*calm));
  EXPECT_LT(with_help.size(), robots.size()) << "some belong together";
}

TEST_F(Servers, OneThatWasCutOffWritesNothingMoreAndEnds) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  RawRobot robot(*parse_peer(first->robots()));
  robot.greet(robot_hello());
  robot.send(keyframe_frame(line_keyframe(1)));
  ASSERT_TRUE(robot.acknowledged(1));
  first->process().signal(SIGSTOP);
  cut_off_who_has_the_database();
  const auto ready = second->await_ready();
  ASSERT_TRUE(ready) << ready.error().message;
  robot.send(keyframe_frame(line_keyframe(2)));  // it lies in the socket of the one that is halted
  first->process().signal(SIGCONT);
  EXPECT_FALSE(robot.acknowledged(2)) << "it ends the connection, and acknowledges nothing";
  const auto ended = first->process().wait(30s);
  ASSERT_TRUE(ended) << ended.error().message;
  EXPECT_EQ(ended->status, 1) << ended->output;
  EXPECT_NE(ended->output.find("was taken over by another headframe-server"), std::string::npos) << ended->output;
  EXPECT_EQ(counts(*second)["ant"].first, 1) << "it wrote nothing";
  RawRobot elsewhere(*parse_peer(second->robots()));
  EXPECT_EQ(elsewhere.greet(robot_hello()).durable_keyframes(), 1U);
  elsewhere.send(keyframe_frame(line_keyframe(2)));
  EXPECT_TRUE(elsewhere.acknowledged(2));
}

TEST_F(Servers, OneThatNobodyWritesToNoticesAllTheSameThatAnotherTookOver) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  first->process().signal(SIGSTOP);
  cut_off_who_has_the_database();
  ASSERT_TRUE(second->await_ready());
  first->process().signal(SIGCONT);
  const auto ended = first->process().wait(30s);
  ASSERT_TRUE(ended) << ended.error().message;
  EXPECT_EQ(ended->status, 1) << ended->output;
}

TEST_F(Servers, OneThatWaitsOutlastsItsDatabaseAndEndsAtASignal) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  ASSERT_TRUE(until([&] { return lists_a_standby(*first); }));
  cluster->kill();
  EXPECT_TRUE(until([&] { return !lists_a_standby(*first); })) << "nothing is heard of anybody";
  ASSERT_TRUE(cluster->start());
  EXPECT_TRUE(until([&] { return lists_a_standby(*first); })) << "the active one goes on, the other one waits again";
  RawRobot robot(*parse_peer(first->robots()));
  robot.greet(robot_hello());
  robot.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(robot.acknowledged(1));
  cluster->kill();
  second->process().signal(SIGTERM);
  const auto ended = second->process().wait(30s);
  ASSERT_TRUE(ended) << ended.error().message;
  EXPECT_EQ(ended->status, 0) << ended->output;
  EXPECT_EQ(first->process().poll(), -1);
}

TEST_F(Servers, OneThatWaitsEndsAtASignalAndIsListedNoMore) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  ASSERT_TRUE(until([&] { return lists_a_standby(*first); }));
  second->process().signal(SIGTERM);
  const auto ended = second->process().wait(10s);
  ASSERT_TRUE(ended) << ended.error().message;
  EXPECT_EQ(ended->status, 0) << ended->output;
  EXPECT_TRUE(until([&] { return rows(*first, "servers").size() == 1; }));
  first->process().signal(SIGTERM);
  const auto last = first->process().wait(10s);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->status, 0) << last->output;
}

TEST_F(Servers, OneThatRobotsWouldNotKnowIsToldSoBeforeItWaits) {
  auto active = BaseStation::start(folder("first"), "127.0.0.1:0", false, config());
  ASSERT_TRUE(active) << active.error().message;
  const auto without = BaseStation::start_standby(folder("second"), config());
  ASSERT_FALSE(without);
  EXPECT_NE(without.error().message.find("identity.pem is missing; copy identity.pem, operator.token and, if it "
                                         "exists, operators.json from the data directory of "),
            std::string::npos)
      << without.error().message;
  EXPECT_NE(without.error().message.find(folder("first").string()), std::string::npos) << without.error().message;
  ASSERT_TRUE(BaseStation::start(folder("other"))) << "with a key of its own, over SQLite";
  fs::create_directories(folder("second"));
  for (const char* file : {"identity.pem", "operator.token"})
    fs::copy_file(folder("other") / file, folder("second") / file);
  const auto other = BaseStation::start_standby(folder("second"), config());
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("its identity.pem differs from the active server's"), std::string::npos)
      << other.error().message;
  fs::copy_file(folder("first") / "identity.pem", folder("second") / "identity.pem",
                fs::copy_options::overwrite_existing);
  const auto token = BaseStation::start_standby(folder("second"), config());
  ASSERT_FALSE(token);
  EXPECT_NE(token.error().message.find("its operator.token differs from the active server's"), std::string::npos)
      << token.error().message;
}

TEST_F(Servers, OneWhosePortIsTakenIsToldSoBeforeItWaits) {
  ASSERT_NO_FATAL_FAILURE(start_both(true));
  const auto third = BaseStation::start_standby(folder("third"), config(), true, first->robots());
  ASSERT_FALSE(third);
  EXPECT_NE(third.error().message.find("cannot listen on " + first->robots()), std::string::npos)
      << third.error().message;
}

TEST(OneServer, OverSqliteIsAloneAndNobodyStandsBy) {
  const ScratchFolder scratch;
  const auto station = BaseStation::start(scratch.path() / "data", "127.0.0.1:0", true);
  ASSERT_TRUE(station) << station.error().message;
  const auto listed = station->command({"servers", "--json"});
  ASSERT_TRUE(listed && listed->status == 0);
  const Json servers = Json::parse(listed->output).at("servers");
  ASSERT_EQ(servers.size(), 1U);
  EXPECT_EQ(servers[0]["role"], "active");
  EXPECT_EQ(servers[0]["robots"], station->robots());
  std::ofstream(scratch.path() / "config.toml") << "[store]\nstandby = true\n";
  const auto refused = BaseStation::start_standby(scratch.path() / "second", scratch.path() / "config.toml", true);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("only one server can use an SQLite database"), std::string::npos)
      << refused.error().message;
}

}  // namespace
}  // namespace headframe::test
