// Sessions that are archived, frozen and deleted through the real programs, and kill -9 in the middle of it.

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

class Tending : public testing::Test {
 protected:
  void SetUp() override {
    write_session(scratch.path() / "a", drive_a_to_c(1));
    write_session(scratch.path() / "b", drive_b_to_a(1));
    start();
    for (const std::string robot : {"a", "b"}) {
      auto process = station->replay(robot, scratch.path() / robot);
      ASSERT_TRUE(process && process->wait(120s)->status == 0);
    }
    ASSERT_EQ(components(), 1U);
  }
  void start() {
    auto started = BaseStation::start(scratch.path() / "data");
    ASSERT_TRUE(started) << started.error().message;
    station.emplace(std::move(*started));
  }
  void restart() {
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
    start();
  }
  std::size_t components() const {
    const auto atlas = station->settled_atlas();
    EXPECT_TRUE(atlas) << atlas.error().message;
    return atlas ? atlas->at("components").size() : 0;
  }
  int run(const std::vector<std::string>& arguments) const {
    const auto ended = station->command(arguments);
    EXPECT_TRUE(ended);
    return ended ? ended->status : -1;
  }
  /// The session of robot b; null: it is gone.
  Json b() const {
    const auto ended = station->command({"sessions", "--json"});
    EXPECT_TRUE(ended && ended->status == 0);
    const Json all = Json::parse(ended->output);
    for (const Json& session : all.at("sessions"))
      if (session.at("robot") == "b") return session;
    return {};
  }
  bool b_is_placed() const {
    const auto atlas = station->settled_atlas();
    for (const Json& component : atlas->at("components"))
      for (const Json& placed : component.at("sessions"))
        if (placed.at("robot") == "b") return true;
    return false;
  }
  /// The server is killed some time after the command was sent, which may have ended by then.
  void kill_in_the_middle_of(const std::vector<std::string>& arguments, std::chrono::milliseconds after) {
    std::vector<std::string> argv{program("headframe"), "--http", station->http(), "--token-file",
                                  station->token_file().string()};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    auto command = Process::start(argv);
    ASSERT_TRUE(command);
    (void)command->wait(after);
    restart();
  }

  ScratchFolder scratch;
  std::optional<BaseStation> station;
};

TEST_F(Tending, AKillInTheMiddleOfAnArchiveLosesNothingAndLeavesNothingHalfDone) {
  const std::uint64_t keyframes = b().at("keyframes");
  bool archived = false;
  int changes = 0;
  for (const int after_ms : {4, 8, 12, 16, 20, 30, 45, 70}) {
    kill_in_the_middle_of({"session", archived ? "restore" : "archive", "b"}, std::chrono::milliseconds(after_ms));
    const bool now = b().at("archived");
    changes += now == archived ? 0 : 1;
    archived = now;
    EXPECT_EQ(b_is_placed(), !archived) << after_ms;
    EXPECT_EQ(components(), 1U) << "a alone, or both in one";
    EXPECT_EQ(b().at("keyframes"), keyframes);
  }
  EXPECT_GT(changes, 0) << "no command got as far as to be done: give it more time";
  EXPECT_EQ(run({"session", "restore", "b"}), archived ? 0 : 1) << "it is there already";
  EXPECT_EQ(components(), 1U);
  EXPECT_TRUE(b_is_placed());
}

TEST_F(Tending, AKillInTheMiddleOfADeleteLeavesAllOfItOrNothing) {
  const std::uint64_t keyframes = b().at("keyframes"), clouds = b().at("clouds");
  EXPECT_EQ(run({"session", "delete", "b"}), 1) << "it asks";
  for (int after_ms = 3; !b().is_null(); after_ms += 3) {
    EXPECT_EQ(b().at("keyframes"), keyframes) << after_ms;
    EXPECT_EQ(b().at("clouds"), clouds) << after_ms;
    EXPECT_EQ(components(), 1U);
    EXPECT_TRUE(b_is_placed()) << after_ms;
    ASSERT_LT(after_ms, 3000);
    kill_in_the_middle_of({"session", "delete", "b", "--yes"}, std::chrono::milliseconds(after_ms));
  }
  EXPECT_FALSE(b_is_placed());
  EXPECT_EQ(components(), 1U) << "a stays";
  EXPECT_EQ(run({"trajectory", "b", (scratch.path() / "b.txt").string()}), 1);
}

TEST_F(Tending, AKillWhileCloudsAreLetGoLosesNoKeyframeAndNoMerge) {
  write_session(scratch.path() / "c", drive_a_to_c(5));
  auto process = station->replay("c", scratch.path() / "c");
  ASSERT_TRUE(process && process->wait(120s)->status == 0);
  ASSERT_EQ(components(), 1U);
  const auto store = [&] { return Json::parse(station->command({"store", "show", "--json"})->output); };
  const auto poses = [&](const std::string& file) {
    EXPECT_EQ(run({"trajectory", "a", (scratch.path() / file).string()}), 0);
    std::ifstream in(scratch.path() / file);
    return std::count(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>(), '\n');
  };
  const auto before = poses("before.txt");
  const std::uint64_t may_go = store().at("may_go").at("clouds");
  ASSERT_GT(may_go, 20U) << "session c has driven where a did";
  EXPECT_EQ(run({"store", "let-go"}), 1) << "it asks";
  for (int after_ms = 2; store().at("may_go").at("clouds") > 0; after_ms += 2) {
    const std::uint64_t gone = store().at("let_go"), left = store().at("may_go").at("clouds");
    EXPECT_EQ(gone + left, may_go) << after_ms;
    ASSERT_LT(after_ms, 2000);
    kill_in_the_middle_of({"store", "let-go", "--mib", "1", "--yes"}, std::chrono::milliseconds(after_ms));
  }
  EXPECT_EQ(store().at("let_go"), may_go);
  EXPECT_EQ(poses("after.txt"), before);
  EXPECT_EQ(run({"merge"}), 0) << "every session is tried again";
  EXPECT_EQ(components(), 1U);
  EXPECT_TRUE(b_is_placed());
}

TEST_F(Tending, WhatIsFrozenHoldsTheMapAcrossAKill) {
  ASSERT_EQ(run({"session", "freeze", "b"}), 0);
  ASSERT_EQ(run({"session", "note", "b", "surveyed in May"}), 0);
  const Json before = station->settled_atlas()->at("components");
  EXPECT_EQ(before.at(0).at("anchor").at("robot"), "b");
  EXPECT_EQ(run({"anchor", "a"}), 1) << "the frozen one keeps the frame";
  restart();
  EXPECT_EQ(station->settled_atlas()->at("components").at(0).at("sessions"), before.at(0).at("sessions"));
  EXPECT_TRUE(b().at("frozen").get<bool>());
  EXPECT_EQ(b().at("note"), "surveyed in May");
  EXPECT_EQ(run({"session", "thaw", "b"}), 0);
  EXPECT_EQ(run({"anchor", "a"}), 0);
}

}  // namespace
}  // namespace headframe::test
