// Robots and a server with a bad link between them: everything arrives exactly once.
#include <gtest/gtest.h>

#include "server/map_merge_server.hpp"
#include "tests/bench/link/audit.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/faulty_proxy.hpp"

namespace headframe::bench {
namespace {

TEST(LinkFaults, CutAndStalledConnectionsLoseAndDoubleNothing) {
  constexpr std::uint64_t keyframes = 40;
  const test::ScratchFolder scratch;
  auto server = MapMergeServer::start({scratch.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}, true});
  ASSERT_TRUE(server) << server.error().message;
  const test::LinkFaults faults;
  const test::FaultyProxy proxy((*server)->robots().port, faults);
  std::map<std::string, std::unique_ptr<RobotClient>> robots;
  for (const std::string name : {"ant", "bee"}) {
    auto robot = RobotClient::open(drive_config(name, scratch.path() / name, "127.0.0.1", proxy.port()));
    ASSERT_TRUE(robot) << robot.error().message;
    robots[name] = std::move(*robot);
  }
  std::map<std::string, Produced> produced;
  std::map<std::string, Told> everything;
  for (std::uint64_t i = 1; i <= keyframes; ++i)
    for (auto& [name, robot] : robots) ASSERT_TRUE(add_drive_keyframe(*robot, name, i).value());
  for (auto& [name, robot] : robots) {
    const auto done = robot->finish(std::chrono::seconds(60));
    ASSERT_TRUE(done) << done.error().message;
    auto made = produce(name, keyframes, scratch.path() / "oracle" / name);
    ASSERT_TRUE(made);
    produced[name] = std::move(*made);
    Told& all = everything[name];
    all.keyframes = all.produced = keyframes;
    for (std::uint64_t s = 1; s <= keyframes; ++s) all.clouds.insert(s);
  }
  const auto found = audit(scratch.path() / "data", produced, everything);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->sum(), 0U) << found->first;
  EXPECT_EQ(found->keyframes, 2 * keyframes);
  EXPECT_GE(proxy.faults(), faults.cuts + faults.stalls);
}

}  // namespace
}  // namespace headframe::bench
