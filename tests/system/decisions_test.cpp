// The operator's decisions through the real programs: robots hear of them, and they survive kill -9.

#include <gtest/gtest.h>

#include <csignal>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// Waits for the robot's line that tells of this revision.
std::string told_of(Process& robot, int revision) {
  const std::string want = "revision " + std::to_string(revision);
  while (const auto line = robot.read_line(60s))
    if (line->find(want) != std::string::npos) return *line;
  return {};
}

struct State {
  std::size_t components = 0;
  int revision = 0;
  std::string alignment;
};

State state_of(const BaseStation& station) {
  const auto atlas = station.settled_atlas();
  EXPECT_TRUE(atlas) << atlas.error().message;
  if (!atlas || atlas->at("alignments").empty()) return {};
  return {atlas->at("components").size(), atlas->at("revision"), atlas->at("alignments")[0].at("state")};
}

TEST(Decisions, AreToldToTheRobotsAndSurviveAKill) {
  const ScratchFolder scratch;
  write_session(scratch.path() / "a", drive_a_to_c(1));
  write_session(scratch.path() / "b", drive_b_to_a(1));
  auto station = BaseStation::start(scratch.path() / "data");
  ASSERT_TRUE(station) << station.error().message;
  auto a = station->replay("a", scratch.path() / "a");
  ASSERT_TRUE(a && a->wait(120s)->status == 0);
  auto b = station->replay("b", scratch.path() / "b", {"--linger", "120"});
  ASSERT_TRUE(b);
  ASSERT_NE(told_of(*b, 1), "");
  EXPECT_EQ(state_of(*station).alignment, "published");

  const auto run = [&](const std::vector<std::string>& arguments) {
    const auto ended = station->command(arguments);
    EXPECT_TRUE(ended) << ended.error().message;
    return ended ? *ended : Process::Ended{};
  };
  const State merged = state_of(*station);
  EXPECT_EQ(run({"retract", "1"}).status, 0);
  EXPECT_NE(told_of(*b, merged.revision + 1), "") << "the robot hears that it stands alone";
  EXPECT_NE(run({"explain", "a", "b"}).output.find("the operator retracted the merge"), std::string::npos);

  const std::string before = run({"explain", "a", "b"}).output;
  station->process().signal(SIGKILL);
  ASSERT_TRUE(station->process().wait(10s));
  station = BaseStation::start(scratch.path() / "data");
  ASSERT_TRUE(station) << station.error().message;
  EXPECT_EQ(run({"merge"}).status, 0);
  const State after = state_of(*station);
  EXPECT_EQ(after.components, 2U) << "the same placement is not merged again";
  EXPECT_NE(after.alignment, "published") << before << run({"explain", "a", "b"}).output;
  EXPECT_EQ(after.revision, merged.revision + 1);

  EXPECT_EQ(run({"undo", "1"}).status, 0);
  EXPECT_EQ(state_of(*station).components, 1U);
  const auto unknown = run({"confirm", "7"});
  EXPECT_NE(unknown.status, 0);
  EXPECT_NE(unknown.output.find("there is no alignment 7"), std::string::npos) << unknown.output;
  EXPECT_EQ(std::count(unknown.output.begin(), unknown.output.end(), '\n'), 1) << unknown.output;
}

}  // namespace
}  // namespace headframe::test
