// Updates of poses in the spool.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <limits>

#include "client/spool/spool.hpp"
#include "common/wire/limits.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

class SpoolPoses : public testing::Test {
 protected:
  Result<Spool> open() {
    Hello h;
    h.session.robot = "rover";
    h.sensor = {"os1-32", 32, 22.5F, 22.5F, 120};
    h.family = {{"scan_context", 1}, 1, 0};
    return Spool::open({folder_.path(), 1 << 20, false}, h);
  }
  static void add(Spool& spool) {
    Keyframe k;
    k.sequence = spool.last_sequence() + 1;
    k.descriptor.q = {1};
    ASSERT_TRUE(spool.append(k, ""));
  }
  static KeyframePose at(std::uint64_t sequence, double x) { return {sequence, pose_from_yaw(0.1, {x, 0, 0})}; }
  static double x(const KeyframePose& pose) { return pose.T_local_sensor.translation().x(); }
  TempDir folder_;
};

TEST_F(SpoolPoses, TheyAreThereAgainWithHowManyKeyframesThereWere) {
  {
    auto spool = open();
    for (int i = 0; i < 3; ++i) add(*spool);
    ASSERT_TRUE(spool->update_poses({at(3, 30), at(1, 10)}));
    add(*spool);
    ASSERT_TRUE(spool->update_poses({at(3, 31), at(4, 40)}));
    ASSERT_TRUE(spool->acknowledge_poses(1));
  }
  const auto spool = open();
  ASSERT_EQ(spool->pose_updates().last(), 2U);
  EXPECT_EQ(spool->pose_updates().acknowledged(), 1U);
  EXPECT_EQ(spool->pose_updates().keyframes_at(1), 3U);
  EXPECT_EQ(spool->pose_updates().keyframes_at(2), 4U);
  const auto both = spool->poses(1, 2);
  ASSERT_TRUE(both);
  ASSERT_EQ(both->size(), 3U);
  EXPECT_EQ(x((*both)[0]), 10);
  EXPECT_EQ(x((*both)[1]), 31) << "the newest of each";
  EXPECT_EQ((*both)[2].sequence, 4U);
  EXPECT_EQ(spool->poses(2, 2)->size(), 2U);
  EXPECT_TRUE(spool->keyframe(3)->T_local_sensor.translation().isZero()) << "it goes as it was, and then the update";
}

TEST_F(SpoolPoses, WhatIsNoneIsRefusedAndLeavesNothing) {
  auto spool = open();
  add(*spool);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& bad : std::vector<std::vector<KeyframePose>>{{},
                                                                {at(0, 1)},
                                                                {at(2, 1)},
                                                                {at(1, 1), at(1, 2)},
                                                                {at(1, nan)},
                                                                {at(1, 2e8)},
                                                                std::vector(limits::update_poses + 1, at(1, 1))}) {
    const auto done = spool->update_poses(bad);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::invalid_argument);
  }
  EXPECT_EQ(spool->pose_updates().last(), 0U);
}

TEST_F(SpoolPoses, ATornOneIsCutOff) {
  {
    auto spool = open();
    add(*spool);
    ASSERT_TRUE(spool->update_poses({at(1, 1)}));
    ASSERT_TRUE(spool->update_poses({at(1, 2)}));
  }
  const auto log = folder_.path() / "session.log";
  std::filesystem::resize_file(log, std::filesystem::file_size(log) - 3);
  const auto spool = open();
  ASSERT_TRUE(spool);
  EXPECT_EQ(spool->pose_updates().last(), 1U);
  EXPECT_FALSE(spool->warnings().empty());
}

/// A child says each update that is on the disk, and is killed at some moment between.
TEST_F(SpoolPoses, OfAKilledRobotAllThatWereSaidToBeThereAreThere) {
  constexpr std::uint64_t many = 400;
  std::uint64_t promised = 0;
  for (int round = 0; round < 5; ++round) {
    int told[2];
    ASSERT_EQ(::pipe(told), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      auto spool = open();
      while (spool && spool->last_sequence() < many) add(*spool);
      for (double i = static_cast<double>(spool->pose_updates().last()) + 1;; ++i) {
        std::vector<KeyframePose> all;
        for (std::uint64_t s = 1; s <= many; ++s) all.push_back(at(s, i));
        if (!spool->update_poses(all) || ::write(told[1], "x", 1) != 1) ::_exit(1);
      }
    }
    char word = 0;
    for (int heard = 0; heard < 7 + 3 * round; ++heard, ++promised) ASSERT_EQ(::read(told[0], &word, 1), 1);
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ::close(told[0]);
    ::close(told[1]);
    const auto spool = open();
    ASSERT_TRUE(spool) << spool.error().message;
    const std::uint64_t last = spool->pose_updates().last();
    ASSERT_GE(last, promised);
    promised = last;
    const auto poses = spool->poses(1, last);
    ASSERT_TRUE(poses);
    ASSERT_EQ(poses->size(), many);
    for (const KeyframePose& pose : *poses) ASSERT_EQ(x(pose), static_cast<double>(last)) << "whole or not at all";
  }
}

}  // namespace
}  // namespace headframe
