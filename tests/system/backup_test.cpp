// A base station that is backed up while a robot maps, killed, and brought back elsewhere.

#include <gtest/gtest.h>

#include <csignal>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

Result<Process::Ended> run_server(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program("headframe-server"));
  auto process = Process::start(arguments);
  if (!process) return tl::unexpected(process.error());
  return process->wait(60s);
}

TEST(Backup, ComesBackElsewhereWithTheSameAtlasAndTheRobotsKnowIt) {
  const ScratchFolder scratch;
  write_session(scratch.path() / "a", drive_a_to_c(1));
  write_session(scratch.path() / "b", drive_b_to_a(1));
  const auto file = (scratch.path() / "backup.db").string();
  nlohmann::json before;
  {
    auto station = BaseStation::start(scratch.path() / "data");
    ASSERT_TRUE(station) << station.error().message;
    for (const std::string robot : {"a", "b"})
      ASSERT_EQ(station->replay(robot, scratch.path() / robot)->wait(120s)->status, 0);
    before = station->settled_atlas().value();
    ASSERT_EQ(before.at("components").size(), 1U);
    const auto made = station->command({"backup", file});
    ASSERT_TRUE(made && made->status == 0) << made->output;
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
  }
  const auto data = scratch.path() / "restored";
  const auto restored = run_server({"--data", data.string(), "--restore", file});
  ASSERT_TRUE(restored && restored->status == 0) << restored->output;
  const auto again = run_server({"--data", data.string(), "--restore", file});
  EXPECT_EQ(again->status, 1) << "it replaces no database";

  auto station = BaseStation::start(data);
  ASSERT_TRUE(station) << station.error().message;
  const auto after = station->settled_atlas().value();
  EXPECT_EQ(after.at("components"), before.at("components"));
  EXPECT_EQ(after.at("revision"), before.at("revision"));
  // The robot's credential is of the server that was killed: it takes the restored one for the same.
  std::filesystem::copy_file(scratch.path() / "data-a.credential", scratch.path() / "restored-a.credential");
  write_session(scratch.path() / "c", drive_d_to_b(1));
  const auto robot = station->replay("a", scratch.path() / "c")->wait(120s);
  EXPECT_EQ(robot->status, 0) << robot->output;
  EXPECT_EQ(station->settled_atlas()->at("components").size(), 1U);
}

}  // namespace
}  // namespace headframe::test
