// When the worker tries a session, and which clouds it waits for.
#include "tests/support/robot_bytes.hpp"
#include "tests/support/scripted_worker.hpp"

namespace headframe {
namespace {

TEST_F(Worker, ARestartFeedsAllAndTriesOnlyWhatNoAttemptHasSeen) {
  keep(PutMerge{2, 5, {}, Atlas{7, {}}, {}});
  start(false);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempts, std::vector<SessionId>{1});
  EXPECT_EQ(script.keyframes[2], (std::vector<std::uint64_t>{1, 2, 3, 4, 5}));
  EXPECT_EQ(script.restored_revision, 7U);
  EXPECT_EQ(store->sessions()->at(0).attempted_keyframes, 5U);
  EXPECT_EQ(worker->view()->atlas.components.size(), 2U) << "sessions that merged with none are components of one";
}

TEST_F(Worker, WhoRestedAndWasTriedAsAWholeIsNotTriedAgainAfterARestartUntilItDrivesOn) {
  for (const SessionId id : {1, 2}) {
    PutMerge tried{id, 5, {}, std::nullopt, {}};
    tried.attempted_whole = id == 1;
    keep(tried);
  }
  worker =
      std::make_unique<MergeWorker>(std::make_unique<ScriptedPipeline>(script), *store, ScheduleConfig{.rest_s = 0});
  ASSERT_TRUE(worker->restore());
  worker->start(robots);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 1 && idle(); }));
  EXPECT_EQ(script.attempts, std::vector<SessionId>{2}) << "it rests from now on";
  EXPECT_EQ(script.completed, (std::set<SessionId>{1, 2}));
  keep(PutKeyframe{1, line_keyframe(6)});
  worker->keyframes_durable(1, 6);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 2 && idle(); }));
  EXPECT_EQ(script.attempts.back(), 1);
}

TEST_F(Worker, WhoEndedAndWasNotTriedAsAWholeIsTriedAfterARestartAndAwaitedUntilThen) {
  for (const SessionId id : {1, 2}) {
    keep(CompleteSession{id});
    PutMerge tried{id, 5, {}, std::nullopt, {}};
    tried.attempted_whole = id == 1;
    keep(tried);
  }
  start(false);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempts, std::vector<SessionId>{2}) << "the server was killed before the last attempt";
  EXPECT_EQ(script.awaited, std::set<SessionId>{2});
}

TEST_F(Worker, ThatASessionWasTriedAsAWholeIsStored) {
  script.on_attempt = [](SessionId id, CloudSource&) {
    AttemptReport report;
    report.whole = id == 1;
    return report;
  };
  start();
  for (const SessionId id : {1, 2}) worker->trigger(id, Trigger::command);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 2 && idle(); }));
  EXPECT_TRUE(store->sessions()->at(0).attempted_whole);
  EXPECT_FALSE(store->sessions()->at(1).attempted_whole);
}

TEST_F(Worker, TheAtlasIsThereBeforeTheKeyframesAreBackAndWhatComesMeanwhileIsFedOnce) {
  const Alignment merged{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
  keep(PutMerge{2, 5, {merged}, Atlas{7, {{1, {{1, Pose::Identity()}, {2, merged.T_a_b}}}}}, {}});
  {
    const std::lock_guard held(script.mutex);  // the pipeline takes no keyframe
    start(false);
    EXPECT_EQ(worker->view()->atlas.revision, 7U);
    ASSERT_EQ(worker->view()->atlas.components.size(), 1U);
    EXPECT_EQ(worker->view()->alignments.size(), 1U);
    EXPECT_FALSE(idle()) << "there is work";
    keep(PutKeyframe{1, line_keyframe(6)});
    worker->keyframes_durable(1, 6);
  }
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.keyframes[1], (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(script.restored_revision, 7U);
}

TEST_F(Worker, DistanceTriggersAndKeyframesComeInOrderOnce) {
  start();
  for (std::uint64_t i = 6; i <= 14; ++i) {
    keep(PutKeyframe{1, line_keyframe(i)});
    worker->keyframes_durable(1, i);
  }
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempted(), 0U) << "9 m";
  keep(PutKeyframe{1, line_keyframe(15)});
  worker->keyframes_durable(1, 15);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempts, std::vector<SessionId>{1});
  ASSERT_EQ(script.keyframes[1].size(), 15U);
  EXPECT_EQ(script.keyframes[1].back(), 15U);
  EXPECT_NEAR(worker->view()->sessions.at(1).distance_m, 14.0, 1e-9);
}

TEST_F(Worker, TheRobotIsToldFromWhereOnItIsLeftOutOfMerging) {
  script.cut_from = 7;
  start();
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_TRUE(robots.cuts.empty());
  for (std::uint64_t i = 6; i <= 8; ++i) {
    keep(PutKeyframe{1, line_keyframe(i)});
    worker->keyframes_durable(1, i);
  }
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(robots.cuts, (std::map<SessionId, SessionCut>{{1, {7, false, "its odometry jumps"}}}));
  EXPECT_NEAR(worker->view()->sessions.at(1).distance_m, 5.0, 1e-9) << "a jump is no way that was driven";
}

TEST_F(Worker, AJunctionTriggersBeforeTheDistanceDoes) {
  start();
  const auto drive = [&](std::uint64_t sequence, PlaceClass place_class) {
    Keyframe keyframe = line_keyframe(sequence);
    keyframe.descriptor.place_class = place_class;
    keep(PutKeyframe{1, keyframe});
    worker->keyframes_durable(1, sequence);
    return eventually([&] { return idle(); });
  };
  for (std::uint64_t i = 6; i <= 11; ++i) ASSERT_TRUE(drive(i, i % 2 == 0 ? PlaceClass::tunnel : PlaceClass::unknown));
  EXPECT_EQ(script.attempted(), 0U) << "6 m of tunnel";
  ASSERT_TRUE(drive(12, PlaceClass::junction));
  EXPECT_EQ(script.attempted(), 1U) << "7 m, at a junction";
  for (std::uint64_t i = 13; i <= 16; ++i) ASSERT_TRUE(drive(i, PlaceClass::junction));
  EXPECT_EQ(script.attempted(), 1U) << "4 m further in the same junction";
  ASSERT_TRUE(drive(17, PlaceClass::tunnel));
  EXPECT_EQ(script.attempted(), 2U) << "5 m, with a junction on the way";
}

TEST_F(Worker, AGoodbyeOrARequestAtRestLetsAShortSessionMerge) {
  start(true, {.asked_rest_s = 0});
  worker->trigger(1, Trigger::link);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_TRUE(script.completed.empty());
  worker->trigger(1, Trigger::goodbye);
  worker->trigger(2, Trigger::request);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.completed, (std::set<SessionId>{1, 2}));
}

TEST_F(Worker, WhomOthersHaveAwaitedLongEnoughIsAwaitedNoMoreAndTheyAreLookedAtAgain) {
  start(true, {.awaited_s = 0});
  ASSERT_TRUE(eventually([&] { return script.attempted() == 2 && idle(); }));
  EXPECT_EQ(script.awaited_no_more, (std::set<SessionId>{1, 2})) << "both grew when the server stopped";
  EXPECT_EQ(script.attempts, (std::vector<SessionId>{1, 2})) << "attempts release what waited";
}

TEST_F(Worker, CloudsAreMadeReadyWhenNoAttemptWaits) {
  std::promise<void> entered, leave;
  script.on_attempt = [&](SessionId id, CloudSource&) {
    if (id == 1) entered.set_value();
    if (id == 1) leave.get_future().wait();
    return AttemptReport();
  };
  start();
  worker->trigger(1, Trigger::goodbye);
  entered.get_future().wait();
  for (std::uint64_t i = 1; i <= 5; ++i) worker->cloud_durable({1, i});
  worker->trigger(2, Trigger::goodbye);
  leave.set_value();
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(script.mutex);
    return script.prepared.size() == 5;
  }));
  for (const auto& [cloud, attempts_before] : script.prepared)
    EXPECT_EQ(attempts_before, 2U) << "whoever sends clouds keeps no attempt waiting";
}

TEST_F(Worker, IsNotIdleFromTheTriggerToTheEndOfItsAttempt) {
  std::promise<void> entered, leave;
  script.on_attempt = [&](SessionId, CloudSource&) {
    entered.set_value();
    leave.get_future().wait();
    return AttemptReport();
  };
  start();
  ASSERT_TRUE(eventually([&] { return idle(); }));
  worker->trigger(1, Trigger::goodbye);
  EXPECT_FALSE(idle());
  entered.get_future().wait();
  EXPECT_FALSE(idle());
  leave.set_value();
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempted(), 1U);
}

TEST_F(Worker, TriggersWhileItIsBusyBecomeOneAttempt) {
  std::promise<void> entered, leave;
  bool first = true;
  script.on_attempt = [&](SessionId, CloudSource&) {
    if (std::exchange(first, false)) {
      entered.set_value();
      leave.get_future().wait();
    }
    return AttemptReport();
  };
  start();
  worker->trigger(1, Trigger::request);
  entered.get_future().wait();
  for (int i = 0; i < 100; ++i) worker->trigger(2, Trigger::request);
  leave.set_value();
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempts, (std::vector<SessionId>{1, 2}));
}

TEST_F(Worker, WantedCloudsAreAskedForOnceAndAwaited) {
  std::vector<CloudState> seen;
  script.on_attempt = [&](SessionId, CloudSource& clouds) {
    AttemptReport report;
    seen.push_back(clouds.state({2, 3}));
    if (seen.back() == CloudState::obtainable) report.wanted = {{2, 3}};
    if (seen.back() == CloudState::stored) {
      EXPECT_EQ(point_count(clouds.load({2, 3}).value()().value()), 400U);
    }
    return report;
  };
  start();
  worker->robot_came(2, true);
  worker->trigger(1, Trigger::request);
  ASSERT_TRUE(eventually([&] { return worker->pending().awaited_submaps == 1; }));
  worker->trigger(1, Trigger::request);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 2; }));
  keep(PutCloud{{2, 3}, small_cloud()});
  worker->cloud_durable({2, 3});
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(seen, (std::vector{CloudState::obtainable, CloudState::obtainable, CloudState::stored}));
  EXPECT_EQ(robots.asked(), (std::vector<KeyframeRef>{{2, 3}}));
}

TEST_F(Worker, CloudsThatWillNotComeEndTheWait) {
  std::vector<CloudState> seen;
  script.on_attempt = [&](SessionId, CloudSource& clouds) {
    AttemptReport report;
    seen.push_back(clouds.state({2, 3}));
    if (seen.back() == CloudState::obtainable) report.wanted = {{2, 3}};
    return report;
  };
  start();
  const auto ask = [&] {
    worker->robot_came(2, true);
    worker->trigger(1, Trigger::request);
    return eventually([&] { return worker->pending().awaited_submaps == 1; });
  };
  ASSERT_TRUE(ask());
  worker->clouds_unavailable(2, {3});
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(seen.back(), CloudState::unobtainable);
  ASSERT_TRUE(ask()) << "a robot that connects again is asked again";
  worker->robot_left(2);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(seen.back(), CloudState::unobtainable);
  EXPECT_EQ(robots.asked().size(), 2U);
}

TEST_F(Worker, RobotsThatNeverSendCloudsAreNotAsked) {
  std::optional<CloudState> seen;
  script.on_attempt = [&](SessionId, CloudSource& clouds) {
    seen = clouds.state({2, 3});
    return AttemptReport();
  };
  start();
  worker->robot_came(2, false);
  worker->trigger(1, Trigger::request);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 1; }));
  EXPECT_EQ(seen, CloudState::unobtainable);
}

}  // namespace
}  // namespace headframe
