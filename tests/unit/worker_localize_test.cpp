// The worker and robots that ask where they are.
#include "tests/support/scripted_worker.hpp"

namespace headframe {
namespace {

class AskingWorker : public Worker {
 protected:
  std::vector<std::pair<SessionId, SessionLocalization>> told() {
    const std::lock_guard lock(robots.mutex);
    return robots.localizations;
  }
  /// What the pipeline knows of every session.
  void known(double probability) {
    const std::lock_guard lock(script.mutex);
    probability_ = probability;
  }
  void begin() {
    script.on_localization = [this](SessionId) {
      const std::lock_guard lock(script.mutex);
      return SessionLocalization{.probability = probability_, .missing = "more path"};
    };
    start();
  }
  bool asked_for(SessionId id) {
    const std::lock_guard lock(script.mutex);
    return script.ask_where.contains(id);
  }

 private:
  double probability_ = 0;
};

TEST_F(AskingWorker, AnswersAtOnceAndTriesTheSession) {
  begin();
  worker->asks_where(2, true);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 1 && idle(); }));
  EXPECT_EQ(script.attempts[0], 2);
  EXPECT_TRUE(asked_for(2));
  ASSERT_EQ(told().size(), 1U) << "the attempt changed nothing";
  EXPECT_EQ(told()[0].first, 2);
  EXPECT_EQ(told()[0].second.missing, "more path");
}

TEST_F(AskingWorker, TellsWhatChangedAndNothingElse) {
  begin();
  worker->asks_where(2, true);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 1 && idle(); }));
  worker->trigger(1, Trigger::command);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 2 && idle(); }));
  EXPECT_EQ(told().size(), 1U);
  known(0.5);
  worker->trigger(1, Trigger::command);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 3 && idle(); }));
  ASSERT_EQ(told().size(), 2U) << "another session's attempt tells of it too";
  EXPECT_EQ(told()[1].second.probability, 0.5);
}

TEST_F(AskingWorker, WhatAnAttemptHasYetToTryMayBeARival) {
  begin();
  bool more = true;
  std::vector<std::size_t> told_before;
  script.on_attempt = [&](SessionId, CloudSource&) {
    told_before.push_back(told().size());
    known(0.1 * static_cast<double>(told_before.size()));
    AttemptReport report;
    report.unfinished = std::exchange(more, false);
    return report;
  };
  worker->asks_where(2, true);
  ASSERT_TRUE(eventually([&] { return script.attempted() == 2 && idle(); }));
  EXPECT_EQ(told_before, (std::vector<std::size_t>{1, 1}));
  ASSERT_EQ(told().size(), 2U);
  EXPECT_EQ(told()[1].second.probability, 0.2);
}

TEST_F(AskingWorker, WhoAsksAgainIsAnsweredAgain) {
  begin();
  worker->asks_where(2, true);
  ASSERT_TRUE(eventually([&] { return told().size() == 1 && idle(); }));
  worker->asks_where(2, true);
  EXPECT_TRUE(eventually([&] { return told().size() == 2 && idle(); }));
}

TEST_F(AskingWorker, WhoLeavesOrAsksNoMoreHearsNoMore) {
  begin();
  for (const bool leaves : {true, false}) {
    worker->asks_where(2, true);
    ASSERT_TRUE(eventually([&] { return asked_for(2) && idle(); }));
    const std::size_t before = told().size();
    leaves ? worker->robot_left(2) : worker->asks_where(2, false);
    ASSERT_TRUE(eventually([&] { return !asked_for(2) && idle(); }));
    known(leaves ? 0.6 : 0.7);
    const std::size_t attempts = script.attempted();
    worker->trigger(2, Trigger::command);
    ASSERT_TRUE(eventually([&] { return script.attempted() == attempts + 1 && idle(); }));
    EXPECT_EQ(told().size(), before);
  }
}

TEST_F(AskingWorker, ARobotThatStandsAndAsksIsNotTakenForOneThatIsDone) {
  script.on_localization = [](SessionId) { return SessionLocalization(); };
  start(true, {.rest_s = 0.05});
  worker->asks_where(2, true);
  ASSERT_TRUE(eventually([&] { return asked_for(2) && idle(); }));
  for (const SessionId id : {1, 2}) {
    keep(PutKeyframe{id, line_keyframe(6)});
    worker->keyframes_durable(id, 6);
  }
  const auto completed = [&](SessionId id) {
    const std::lock_guard lock(script.mutex);
    return script.completed.contains(id);
  };
  ASSERT_TRUE(eventually([&] { return completed(1); }));
  EXPECT_FALSE(completed(2));
}

}  // namespace
}  // namespace headframe
