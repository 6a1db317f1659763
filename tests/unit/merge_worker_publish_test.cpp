// What the worker publishes, and the operator's orders.
#include "server/store/sqlite.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/scripted_worker.hpp"

namespace headframe {
namespace {

TEST_F(Worker, ATransformIsPublishedAfterItIsDurable) {
  script.on_attempt = [&](SessionId, CloudSource&) {
    const Alignment alignment{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
    script.alignments = {alignment};
    script.atlas = {3, {{1, {{1, Pose::Identity()}, {2, alignment.T_a_b}}}}};
    return AttemptReport{{}, false, {alignment}, true, {}, {}};
  };
  std::uint64_t on_disk = 0;
  robots.on_publish = [&] { on_disk = store->merge()->atlas.revision; };
  start();
  worker->trigger(2, Trigger::goodbye);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(on_disk, 3U);
  ASSERT_EQ(robots.changed.size(), 1U);
  EXPECT_EQ(robots.changed[0].placements.size(), 2U);
  EXPECT_EQ(worker->view()->atlas.revision, 3U);
  EXPECT_GE(worker->view()->sessions.at(2).trigger_to_transform_ms, 0);
  EXPECT_GE(worker->view()->sessions.at(1).trigger_to_transform_ms, 0) << "the same attempt placed both";
}

/// Waits for the outcome of a decision.
Result<void> decided(MergeWorker& worker, AlignmentId alignment, Decision decision) {
  std::promise<Result<void>> outcome;
  worker.decide(alignment, decision, [&](const Result<void>& result) { outcome.set_value(result); });
  return outcome.get_future().get();
}

TEST_F(Worker, ADecisionIsDurableAndToldBeforeItIsAnswered) {
  script.on_decision = [&](AlignmentId id, Decision decision) {
    AttemptReport report;
    const Pose T = pose_from_yaw(0.5, {1, 2, 3});
    report.changed = {{id, 1, 2, AlignmentState::published, T, {}}};
    report.decided = {{1, id, decision, T, 10, false}};
    report.atlas_changed = true;
    script.alignments = report.changed;
    script.atlas = {script.atlas.revision + 3, {{1, {{1, Pose::Identity()}, {2, T}}}}};
    return report;
  };
  start();
  ASSERT_TRUE(decided(*worker, 7, Decision::confirm));
  EXPECT_EQ(robots.changed.size(), 1U);
  EXPECT_EQ(worker->view()->atlas.revision, 3U);
  const auto stored = store->merge();
  EXPECT_EQ(stored->atlas.revision, 3U);
  ASSERT_EQ(stored->decisions.size(), 1U);
  EXPECT_EQ(stored->decisions[0].alignment, 7);
  EXPECT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempted(), 0U);
  ASSERT_TRUE(decided(*worker, 7, Decision::undo));
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.attempts, std::vector<SessionId>{2}) << "an undo looks again";
}

TEST_F(Worker, WhatWasDecidedIsShownFromTheFirstMomentAfterARestart) {
  const Alignment placed{7, 1, 2, AlignmentState::candidate, pose_from_yaw(0.5, {1, 2, 3}), {}};
  PutMerge write;
  write.changed = {placed};
  write.decided = {{1, 7, Decision::place, placed.T_a_b, 10, false}};
  keep(write);
  worker = std::make_unique<MergeWorker>(std::make_unique<ScriptedPipeline>(script), *store, ScheduleConfig{});
  ASSERT_TRUE(worker->restore());
  const auto view = worker->view();
  ASSERT_EQ(view->alignments.size(), 1U) << "before the pipeline has anything of it";
  EXPECT_EQ(view->alignments[0].ruling, Ruling::placed);
}

TEST_F(Worker, AnAnchorIsDurableToldAndFoundAgain) {
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  script.atlas = {3, {{1, {{1, Pose::Identity()}, {2, T}}}}};
  script.on_anchor = [&](SessionId id) -> Result<AttemptReport> {
    if (id != 2) return failure(ErrorCode::not_found, "there is no session 9");
    AttemptReport report;
    report.anchored = id;
    report.atlas_changed = true;
    script.atlas = {4, {{2, {{1, T.inverse()}, {2, Pose::Identity()}}}}};
    return report;
  };
  start();
  const auto anchored = [&](SessionId id) {
    std::promise<Result<void>> outcome;
    worker->anchor(id, [&](const Result<void>& result) { outcome.set_value(result); });
    return outcome.get_future().get();
  };
  ASSERT_TRUE(anchored(2));
  ASSERT_EQ(robots.changed.size(), 1U);
  EXPECT_EQ(robots.changed[0].id, 2);
  EXPECT_EQ(worker->view()->atlas.revision, 4U);
  EXPECT_EQ(anchored(9).error().code, ErrorCode::not_found);
  worker.reset();
  start();
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(script.anchors, std::vector<SessionId>{2});
}

TEST_F(Worker, AsksForTheCloudsThatAreMissingWhenTheRobotIsThere) {
  keep(PutCloud{{1, 2}, "cloud"});
  start();
  const auto asked = [&](SessionId id) {
    std::promise<Result<std::size_t>> outcome;
    worker->request_clouds(id, [&](const Result<std::size_t>& result) { outcome.set_value(result); });
    return outcome.get_future().get();
  };
  EXPECT_EQ(asked(1).error().code, ErrorCode::refused) << "the robot is away";
  EXPECT_EQ(asked(9).error().code, ErrorCode::not_found);
  worker->robot_came(1, false);
  EXPECT_EQ(asked(1).error().code, ErrorCode::refused) << "it sends no clouds";
  worker->robot_came(1, true);
  EXPECT_EQ(asked(1), 4U);
  EXPECT_EQ(robots.asked(), (std::vector<KeyframeRef>{{1, 1}, {1, 3}, {1, 4}, {1, 5}}));
  worker->robot_left(1);
  EXPECT_EQ(asked(1).error().code, ErrorCode::refused);
}

TEST_F(Worker, ADatabaseThatCanNotBeWrittenEndsMergingWithAWord) {
  script.on_attempt = [](SessionId, CloudSource&) {
    AttemptReport report;
    report.changed = {{1, 1, 2, AlignmentState::candidate, Pose::Identity(), {}}};
    return report;
  };
  start();
  auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
  ASSERT_TRUE(database && database->execute("DROP TABLE alignments"));
  worker->trigger(1, Trigger::command);
  ASSERT_TRUE(eventually([&] { return !store->load().broken.empty(); }));
  const auto refused = decided(*worker, 7, Decision::confirm);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("until the server is started anew"), std::string::npos)
      << refused.error().message;
  EXPECT_TRUE(eventually([&] { return idle(); })) << "nobody waits for what will not come";
  EXPECT_EQ(script.attempted(), 1U);
}

TEST_F(Worker, DecisionsThatFailSaySoAndTooManyAreTurnedAway) {
  std::promise<void> entered, leave;
  script.on_attempt = [&](SessionId, CloudSource&) {
    entered.set_value();
    leave.get_future().wait();
    return AttemptReport();
  };
  script.on_decision = [](AlignmentId, Decision) -> Result<AttemptReport> {
    return failure(ErrorCode::not_found, "there is no alignment 7");
  };
  start();
  worker->trigger(1, Trigger::command);
  entered.get_future().wait();
  std::atomic<int> not_found = 0, turned_away = 0;
  for (int i = 0; i < 70; ++i)
    worker->decide(7, Decision::confirm, [&](const Result<void>& result) {
      ASSERT_FALSE(result);
      (result.error().code == ErrorCode::not_found ? not_found : turned_away) += 1;
    });
  EXPECT_EQ(turned_away, 6) << "while the worker is busy, 64 wait";
  leave.set_value();
  ASSERT_TRUE(eventually([&] { return not_found == 64; }));
  worker->stop();
  EXPECT_EQ(decided(*worker, 7, Decision::confirm).error().code, ErrorCode::unavailable);
}

TEST_F(Worker, UnfinishedAttemptsGoOnAndExceptionsEndOne) {
  int left = 3;
  script.on_attempt = [&](SessionId id, CloudSource&) {
    if (id == 2) throw std::runtime_error("out of memory, say");
    return AttemptReport{{}, --left > 0, {}, false, {}, {}};
  };
  start();
  worker->trigger(1, Trigger::command);
  worker->trigger(2, Trigger::command);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  EXPECT_EQ(left, 0);
}

TEST_F(Worker, WhatIsProvisionalIsToldWithoutARevision) {
  script.on_attempt = [&](SessionId, CloudSource&) {
    script.atlas.components = {{1, {{1, Pose::Identity()}}, {{2, pose_from_yaw(0.5, {1, 2, 3}), 0.97, 25}}},
                               {2, {{2, Pose::Identity()}}}};
    AttemptReport report;
    report.provisional_changed = true;
    return report;
  };
  start();
  worker->trigger(2, Trigger::travelled);
  ASSERT_TRUE(eventually([&] { return idle(); }));
  const std::lock_guard lock(robots.mutex);
  EXPECT_TRUE(robots.changed.empty());
  ASSERT_EQ(robots.provisional.size(), 1U);
  EXPECT_EQ(robots.provisional[0].id, 1);
  EXPECT_EQ(store->merge()->atlas.revision, 0U);
  EXPECT_EQ(worker->view()->atlas.components[0].provisional.size(), 1U);
}

TEST_F(Worker, RobotsAreToldWhyAMergeWasWithdrawn) {
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  bool found = false;
  script.on_attempt = [&](SessionId, CloudSource&) {
    const bool first = !std::exchange(found, true);
    const Alignment now{1, 1, 2, first ? AlignmentState::published : AlignmentState::verified, T, {}};
    script.alignments = {now};
    if (first)
      script.atlas = {1, {{1, {{1, Pose::Identity()}, {2, T}}}}};
    else
      script.atlas = {2, {{1, {{1, Pose::Identity()}}}, {2, {{2, Pose::Identity()}}}}};
    return AttemptReport{{}, false, {now}, true, {}, {}};
  };
  start();
  for (int i = 0; i < 2; ++i) {
    worker->trigger(2, Trigger::command);
    ASSERT_TRUE(eventually([&] { return idle(); }));
  }
  const std::lock_guard lock(robots.mutex);
  ASSERT_EQ(robots.withdrawn.size(), 1U);
  EXPECT_EQ(robots.withdrawn[0].a, 1);
  EXPECT_EQ(robots.withdrawn[0].b, 2);
  EXPECT_EQ(robots.withdrawn[0].reason, "other sessions contradict it");
  EXPECT_EQ(worker->effort().withdrawn, 1U);
}

TEST(ChangedComponents, AreThoseWithOtherPlacementsAndThoseThatFellApart) {
  const Pose I = Pose::Identity(), T = pose_from_yaw(0.5, {1, 2, 3});
  const Atlas singles{0, {{1, {{1, I}}}, {2, {{2, I}}}, {3, {{3, I}}}}};
  const Atlas pair{1, {{1, {{1, I}, {2, T}}}, {3, {{3, I}}}}};
  const Atlas moved{2, {{1, {{1, I}, {2, I}}}, {3, {{3, I}}}}};
  const auto ids = [](const std::vector<Component>& components) {
    std::vector<SessionId> all(components.size());
    std::transform(components.begin(), components.end(), all.begin(), [](const Component& c) { return c.id; });
    return all;
  };
  EXPECT_TRUE(changed_components({}, singles).empty());
  EXPECT_TRUE(changed_components(pair, pair).empty());
  EXPECT_EQ(ids(changed_components(singles, pair)), std::vector<SessionId>{1});
  EXPECT_EQ(ids(changed_components(pair, moved)), std::vector<SessionId>{1});
  EXPECT_EQ(ids(changed_components(pair, singles)), (std::vector<SessionId>{1, 2}));
}

}  // namespace
}  // namespace headframe
