// How the worker takes in where keyframes lie that a robot's SLAM moved.
#include "tests/support/scripted_worker.hpp"

namespace headframe {
namespace {

class WorkerPoses : public Worker {
 protected:
  static PutPoses update(std::uint64_t number, std::uint64_t keyframes, const std::vector<std::uint64_t>& sequences) {
    PutPoses put{1, number, {}};
    put.sessions[1].keyframes = keyframes;
    for (const std::uint64_t s : sequences)
      put.sessions[1].poses.push_back({s, pose_from_yaw(0, {1000.0 + static_cast<double>(s), 0, 0})});
    return put;
  }
  void say(const PutPoses& put) {
    keep(put);
    worker->poses_durable(1);
  }
  bool waits() { return store->new_poses(1)->number > 0; }
  std::size_t moves() {
    const std::lock_guard lock(script.mutex);
    return script.moved.size();
  }
  std::vector<double> xs(std::size_t move) {
    const std::lock_guard lock(script.mutex);
    std::vector<double> all;
    for (const Keyframe& k : script.moved.at(move).second) all.push_back(position(k).x());
    return all;
  }
};

TEST_F(WorkerPoses, AnUpdateIsTakenInAndTheSessionIsTriedAgain) {
  start();
  say(update(1, 5, {2, 5}));
  ASSERT_TRUE(eventually([&] { return script.attempted() == 1 && idle(); }));
  ASSERT_EQ(moves(), 1U);
  EXPECT_EQ(xs(0), (std::vector<double>{1, 1002, 3, 4, 1005})) << "all of the session, where it lies now";
  EXPECT_FALSE(waits());
  EXPECT_EQ(robots.moved, std::vector<SessionId>{1});
  EXPECT_GT(worker->view()->sessions.at(1).distance_m, 3000) << "and its path is as long as it is now";
  double x = 0;
  ASSERT_TRUE(store->each_keyframe(1, 5, [&](const Keyframe& k) { x = position(k).x(); }));
  EXPECT_EQ(x, 1005);
}

TEST_F(WorkerPoses, AMergeThatItWithdrawsIsAnIncidentAsAnyOther) {
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  Alignment merged{1, 1, 2, AlignmentState::published, T, {}};
  const Atlas together{1, {{1, {{1, Pose::Identity()}, {2, T}}}}},
      apart{2, {{1, {{1, Pose::Identity()}}}, {2, {{2, Pose::Identity()}}}}};
  script.atlas = together;
  script.alignments = {merged};
  PutMerge before;
  before.changed = {merged};
  before.atlas = together;
  keep(before);
  script.on_move = [&](AttemptReport& report) {
    merged.state = AlignmentState::verified;
    script.atlas = apart;
    script.alignments = {merged};
    report.changed = {merged};
  };
  start();
  say(update(1, 5, {2, 5}));
  ASSERT_TRUE(eventually([&] { return script.attempted() == 1 && idle(); }));
  EXPECT_EQ(worker->effort().withdrawn, 1U);
  const std::lock_guard lock(robots.mutex);
  ASSERT_EQ(robots.withdrawn.size(), 1U);
  EXPECT_EQ(robots.withdrawn[0].reason, "a robot's SLAM moved where it had been, and other sessions contradict it");
  EXPECT_EQ(worker->view()->alignments.at(0).state, AlignmentState::verified) << "which the page makes an alarm of";
}

TEST_F(WorkerPoses, OneThatMovesNothingIsNotTriedAgain) {
  script.moves_anything = false;
  start();
  say(update(1, 5, {2}));
  ASSERT_TRUE(eventually([&] { return moves() == 1 && idle(); }));
  EXPECT_EQ(script.attempted(), 0U);
  EXPECT_FALSE(waits());
  EXPECT_EQ(store->sessions()->at(0).attempted_keyframes, 5U);
  EXPECT_TRUE(robots.moved.empty());
}

TEST_F(WorkerPoses, WhatCameBehindAnUpdateIsGivenToThePipelineAfterIt) {
  start();
  keep(update(1, 5, {5}));
  keep(PutKeyframe{1, line_keyframe(6)});
  keep(PutKeyframe{1, line_keyframe(7)});
  worker->keyframes_durable(1, 5);  // of what the store has more, the worker has not heard
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.keyframes[1].size(), 5U);
  worker->poses_durable(1);
  worker->keyframes_durable(1, 7);
  // Tried once, or twice where the worker had taken in the poses before it heard of the keyframes.
  ASSERT_TRUE(eventually([&] { return script.attempted() >= 1 && idle(); }));
  ASSERT_EQ(moves(), 1U);
  EXPECT_EQ(xs(0).size(), 5U);
  EXPECT_EQ(script.keyframes[1].size(), 7U);
}

TEST_F(WorkerPoses, AfterARestartAlignmentsAreRestoredWithThePosesThatTheyAreOfAndThenMoved) {
  keep(PutKeyframe{1, line_keyframe(6)});
  keep(update(3, 5, {4}));
  start(false);
  ASSERT_TRUE(eventually([&] { return moves() == 1 && script.attempted() >= 1 && idle(); }));
  EXPECT_EQ(xs(0), (std::vector<double>{1, 2, 3, 1004, 5})) << "what came behind it, only then";
  EXPECT_EQ(script.keyframes[1].size(), 6U);
  EXPECT_FALSE(waits());
  worker.reset();
  start(false);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(moves(), 1U) << "once";
}

TEST_F(WorkerPoses, ThoseOfAFrozenSessionAndWhatComesBehindThemWaitUntilItIsThawed) {
  start();
  const auto freeze = [&](bool frozen) {
    std::promise<Result<void>> done;
    worker->freeze(1, frozen, [&](const Result<void>& result) { done.set_value(result); });
    ASSERT_TRUE(done.get_future().get());
  };
  freeze(true);
  say(update(1, 5, {2}));
  keep(PutKeyframe{1, line_keyframe(6)});
  worker->keyframes_durable(1, 6);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(moves(), 0U);
  EXPECT_TRUE(waits());
  EXPECT_EQ(script.keyframes[1].size(), 5U);
  freeze(false);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(moves(), 1U);
  EXPECT_FALSE(waits());
  EXPECT_EQ(script.keyframes[1].size(), 6U);
}

TEST_F(WorkerPoses, ThoseOfOneThatIsSetAsideAreTakenInWhenItComesBack) {
  start();
  const auto wait = [](auto call) {
    std::promise<Result<void>> done;
    call([&](const Result<void>& result) { done.set_value(result); });
    ASSERT_TRUE(done.get_future().get());
  };
  wait([&](auto done) { worker->set_aside(1, "a trial", done); });
  say(update(1, 5, {2}));
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(moves(), 0U);
  wait([&](auto done) { worker->release(1, done); });
  EXPECT_EQ(moves(), 1U);
  EXPECT_FALSE(waits());
}

}  // namespace
}  // namespace headframe
