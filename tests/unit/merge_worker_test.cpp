#include "server/merge_worker/merge_worker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>

#include "server/store/sqlite.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

/// Spins until it is so; false after ten seconds.
template <class Condition>
bool eventually(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

/// Does what the test's script says at each attempt, and keeps what it was told.
struct Script {
  std::mutex mutex;
  std::map<SessionId, std::vector<std::uint64_t>> keyframes;
  std::vector<SessionId> attempts;
  std::vector<std::pair<KeyframeRef, std::size_t>> prepared;  // clouds, and how many attempts there were before
  std::set<SessionId> completed;
  std::uint64_t restored_revision = 0;
  std::function<AttemptReport(SessionId, CloudSource&)> on_attempt = [](SessionId, CloudSource&) {
    return AttemptReport();
  };
  std::function<Result<AttemptReport>(AlignmentId, Decision)> on_decision = [](AlignmentId, Decision) {
    return AttemptReport();
  };
  std::function<Result<AttemptReport>(SessionId)> on_anchor = [](SessionId) { return AttemptReport(); };
  Atlas atlas;
  std::vector<Alignment> alignments;
  std::vector<SessionId> anchors;

  std::size_t attempted() {
    const std::lock_guard lock(mutex);
    return attempts.size();
  }
};

class ScriptedPipeline : public Pipeline {
 public:
  explicit ScriptedPipeline(Script& script) : script_(script) {}
  void add_session(SessionId, const FamilyId&) override {}
  void add_keyframe(SessionId id, Keyframe keyframe) override {
    const std::lock_guard lock(script_.mutex);
    script_.keyframes[id].push_back(keyframe.sequence);
  }
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource&) override {
    const std::lock_guard lock(script_.mutex);
    script_.prepared.push_back({keyframe, script_.attempts.size()});
  }
  void complete_session(SessionId id) override {
    const std::lock_guard lock(script_.mutex);
    script_.completed.insert(id);
  }
  Result<AttemptReport> decide(AlignmentId id, Decision decision) override { return script_.on_decision(id, decision); }
  void restore(std::vector<Alignment> alignments, std::uint64_t revision, std::vector<DecisionRecord>,
               std::vector<SessionId> anchors) override {
    script_.anchors = std::move(anchors);
    script_.alignments = std::move(alignments);
    script_.restored_revision = revision;
  }
  Result<AttemptReport> anchor(SessionId id) override { return script_.on_anchor(id); }
  AttemptReport attempt(SessionId id, CloudSource& clouds) override {
    auto report = script_.on_attempt(id, clouds);
    const std::lock_guard lock(script_.mutex);
    script_.attempts.push_back(id);
    return report;
  }
  const Atlas& atlas() const override { return script_.atlas; }
  const std::vector<Alignment>& alignments() const override { return script_.alignments; }

 private:
  Script& script_;
};

struct FakeRobots : Robots {
  std::mutex mutex;
  std::vector<KeyframeRef> requested;
  std::vector<Component> changed;
  std::function<void()> on_publish = [] {};

  void request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) override {
    const std::lock_guard lock(mutex);
    for (const std::uint64_t sequence : sequences) requested.push_back({session, sequence});
  }
  void publish(const Atlas&, const std::vector<Component>& components) override {
    on_publish();
    const std::lock_guard lock(mutex);
    changed = components;
  }
  std::vector<KeyframeRef> asked() {
    const std::lock_guard lock(mutex);
    return requested;
  }
};

class Worker : public testing::Test {
 protected:
  void SetUp() override {
    store = std::move(open_sqlite_store(dir.path(), {.group_ms = 0}).value());
    for (const SessionId id : {1, 2}) {
      keep(PutSession{session_record(id, "robot" + std::to_string(id))});
      for (std::uint64_t i = 1; i <= 5; ++i) keep(PutKeyframe{id, line_keyframe(i)});
    }
  }

  void keep(Write write) {
    std::promise<void> durable;
    store->write(std::move(write), [&](const Result<void>& result) {
      EXPECT_TRUE(result) << result.error().message;
      durable.set_value();
    });
    durable.get_future().wait();
  }

  /// As after a restart, with every session attempted already or not.
  void start(bool attempted = true, const ScheduleConfig& schedule = {}) {
    if (attempted)
      for (const SessionId id : {1, 2}) keep(PutMerge{id, 5, {}, std::nullopt, {}});
    worker = std::make_unique<MergeWorker>(std::make_unique<ScriptedPipeline>(script), *store, schedule);
    ASSERT_TRUE(worker->restore());
    worker->start(robots);
  }

  bool idle() const { return worker->pending().idle(); }

  TempDir dir;
  Script script;
  FakeRobots robots;
  std::unique_ptr<Store> store;
  std::unique_ptr<MergeWorker> worker;  // gone before the others
};

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
      EXPECT_EQ(point_count(clouds.load({2, 3}).value()), 400U);
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
  auto database = Database::open((dir.path() / "headframe.db").string());
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
