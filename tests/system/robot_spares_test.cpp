// Connections that stand beside the one that carries a session, met by robots that are written byte by byte.
#include <gtest/gtest.h>

#include "server/map_merge_server.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

std::string slow_keyframe(std::uint64_t sequence) { return keyframe_frame(line_keyframe(sequence, 0.001)); }

Hello hello_of_run(std::uint64_t run, bool spare) {
  Hello hello = robot_hello();
  for (std::uint64_t r = 10; r <= run; ++r) hello.spool_runs.push_back(r);
  hello.spare = spare;
  return hello;
}

class Spares : public testing::Test {
 protected:
  void serve(int spares) {
    ServerConfig config;
    config.limits.spares = spares;
    auto started = MapMergeServer::start({dir.path(), {"127.0.0.1", 0}, {"127.0.0.1", 0}, config, true});
    ASSERT_TRUE(started) << started.error().message;
    server = std::move(*started);
  }
  v1::ErrorReport refusal(const Hello& hello) {
    RawRobot robot(server->robots());
    robot.send(hello_frame(hello));
    return robot.error();
  }

  TempDir dir;
  std::unique_ptr<MapMergeServer> server;
};

TEST_F(Spares, ASpareDisturbsNobodyAndBringsTheSameKeyframesOnce) {
  serve(2);
  RawRobot first(server->robots()), spare(server->robots());
  EXPECT_EQ(first.greet(hello_of_run(10, false)).spares(), 2U);
  spare.greet(hello_of_run(10, true));
  first.send(slow_keyframe(1));
  EXPECT_TRUE(first.acknowledged(1)) << "it was not replaced";
  spare.send(probe_frame(true) + slow_keyframe(2));
  EXPECT_TRUE(spare.acknowledged(2));
  first.send(slow_keyframe(2) + slow_keyframe(3));
  EXPECT_TRUE(first.acknowledged(3));
  spare.send(probe_frame(false));
  EXPECT_TRUE(spare.acknowledged(3));
}

TEST_F(Spares, WhoTakesOverCarriesTheSessionAndTheOtherStandsBy) {
  serve(2);
  RawRobot first(server->robots()), spare(server->robots());
  first.greet(hello_of_run(10, false));
  spare.greet(hello_of_run(10, true));
  spare.send(probe_frame(true) + slow_keyframe(1) + take_over_frame() + slow_keyframe(2));
  EXPECT_TRUE(spare.acknowledged(2));
  first.send(probe_frame(true) + slow_keyframe(3));
  EXPECT_TRUE(first.acknowledged(3));
  first.send(take_over_frame() + slow_keyframe(4));
  EXPECT_TRUE(first.acknowledged(4)) << "and back again";
}

TEST_F(Spares, OneMoreThanAllowedClosesTheOldest) {
  serve(1);
  RawRobot first(server->robots()), older(server->robots()), newer(server->robots());
  first.greet(hello_of_run(10, false));
  older.greet(hello_of_run(10, true));
  newer.greet(hello_of_run(10, true));
  const auto report = older.error();
  EXPECT_FALSE(report.permanent());
  EXPECT_NE(report.message().find("limits.spares"), std::string::npos) << report.message();
  newer.send(probe_frame(false));
  EXPECT_TRUE(newer.acknowledged(0));
}

TEST_F(Spares, NoneStandsWhereNoneMay) {
  serve(0);
  RawRobot first(server->robots());
  EXPECT_EQ(first.greet(hello_of_run(10, false)).spares(), 0U);
  EXPECT_FALSE(refusal(hello_of_run(10, true)).permanent());
  first.send(slow_keyframe(1));
  EXPECT_TRUE(first.acknowledged(1));
}

TEST_F(Spares, AnotherRunOrCopyOfTheSpoolHasNoSpareHere) {
  serve(2);
  RawRobot first(server->robots()), spare(server->robots());
  first.greet(hello_of_run(11, false));
  EXPECT_TRUE(refusal(hello_of_run(10, true)).permanent()) << "a copy that does not know run 11";
  spare.greet(hello_of_run(11, true));
  EXPECT_FALSE(refusal(hello_of_run(12, true)).permanent()) << "a run that was not let in";
  RawRobot second(server->robots());
  second.greet(hello_of_run(12, false));
  EXPECT_FALSE(first.error().permanent());
  EXPECT_FALSE(spare.error().permanent()) << "the robot was started anew: its spares are gone";
}

}  // namespace
}  // namespace headframe
