// A session that work keeps failing on is set aside, and all else goes on.

#include <gtest/gtest.h>

#include <algorithm>
#include <future>

#include "server/merge_worker/merge_worker.hpp"
#include "server/support/parallel.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

struct Log {
  std::map<SessionId, std::size_t> fed = {};
  std::map<SessionId, std::string> sites = {};
  std::vector<SessionId> attempts = {}, aside = {}, back = {}, frozen = {}, thawed = {};
  std::function<void(SessionId)> on_attempt = [](SessionId) {};
};

class LoggingPipeline : public Pipeline {
 public:
  explicit LoggingPipeline(Log& log) : log_(log) {}
  void add_session(SessionId id, const FamilyId&, const std::string& site) override { log_.sites[id] = site; }
  AttemptReport set_site(SessionId id, const std::string& site) override {
    log_.sites[id] = site;
    return {};
  }
  void add_keyframe(SessionId id, Keyframe) override { ++log_.fed[id]; }
  void complete_session(SessionId) override {}
  void restore(std::vector<Alignment>, std::uint64_t, std::vector<DecisionRecord>, std::vector<SessionId>) override {}
  Result<AttemptReport> decide(AlignmentId, Decision) override { return AttemptReport(); }
  Result<AttemptReport> anchor(SessionId) override { return AttemptReport(); }
  AttemptReport attempt(SessionId id, CloudSource&) override {
    log_.attempts.push_back(id);
    log_.on_attempt(id);
    return {};
  }
  AttemptReport set_aside(SessionId id) override {
    log_.aside.push_back(id);
    return {};
  }
  AttemptReport come_back(SessionId id) override {
    log_.back.push_back(id);
    return {};
  }
  Result<AttemptReport> freeze(SessionId id) override {
    log_.frozen.push_back(id);
    AttemptReport report;
    report.frozen.push_back({id, id});
    return report;
  }
  Result<AttemptReport> thaw(SessionId id) override {
    AttemptReport report;
    report.thawed = id;
    return report;
  }
  void restore_frozen(const std::vector<FrozenSession>& frozen) override {
    for (const FrozenSession& f : frozen) log_.frozen.push_back(f.session);
  }
  const Atlas& atlas() const override { return atlas_; }
  const std::vector<Alignment>& alignments() const override { return alignments_; }

 private:
  Log& log_;
  Atlas atlas_;
  std::vector<Alignment> alignments_;
};

struct NoRobots : Robots {
  void tell_localization(SessionId, const SessionLocalization&) override {}
  void tell_cut(SessionId, const SessionCut&) override {}
  void request_submap(SessionId, const std::vector<std::uint64_t>&) override {}
  void publish(const Atlas&, const std::vector<Component>&, const std::vector<Withdrawal>&) override {}
  void tell_provisional(const Atlas&, const std::vector<Component>&) override {}
};

class Aside : public testing::Test {
 protected:
  void SetUp() override {
    store = open(dir);
    for (const SessionId id : {1, 2, 3}) {
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
      for (std::uint64_t i = 1; i <= 4; ++i) ASSERT_TRUE(write_and_wait(*store, PutKeyframe{id, line_keyframe(i)}));
    }
  }
  std::filesystem::path mark_file() const { return dir.path() / "merging"; }
  void start() {
    worker.reset();
    log = {.on_attempt = log.on_attempt};
    worker = std::make_unique<MergeWorker>(std::make_unique<LoggingPipeline>(log), *store, schedule,
                                           std::move(WorkMark::open(mark_file()).value()));
    ASSERT_TRUE(worker->restore());
    worker->start(robots);
  }
  /// The server dies, or is killed, in the middle of work on these two; then it starts again.
  void end_in_the_middle_of(SessionId a, SessionId b, bool of_itself) {
    worker.reset();
    {
      auto mark = WorkMark::open(mark_file()).value();
      mark.on(a, b);
      if (of_itself) WorkMark::died();
    }
    start();
    settle();
  }
  Result<void> wait_for(const std::function<void(std::function<void(const Result<void>&)>)>& order) {
    std::promise<Result<void>> done;
    order([&](const Result<void>& result) { done.set_value(result); });
    return done.get_future().get();
  }
  std::string why(SessionId id) {
    const auto view = worker->view();
    const auto shown = view->sessions.find(id);
    return shown == view->sessions.end() ? "" : shown->second.why_aside;
  }
  bool attempted(SessionId id) { return std::count(log.attempts.begin(), log.attempts.end(), id) > 0; }
  void settle() {
    ASSERT_TRUE(wait_for([&](auto done) { worker->anchor(1, std::move(done)); }));
  }

  TempDir dir;
  Log log;
  ScheduleConfig schedule;
  NoRobots robots;
  std::unique_ptr<Store> store;
  std::unique_ptr<MergeWorker> worker;
};

TEST_F(Aside, WorkThatEndedTheServerTwiceIsNotDoneAThirdTime) {
  end_in_the_middle_of(2, 2, true);
  EXPECT_EQ(why(2), "");
  EXPECT_EQ(log.fed[2], 4U);
  end_in_the_middle_of(2, 2, true);
  EXPECT_NE(why(2).find("2 times"), std::string::npos) << why(2);
  EXPECT_EQ(log.fed[2], 0U) << "the pipeline hears nothing of it";
  EXPECT_EQ(log.fed[1], 4U);
  start();
  EXPECT_NE(why(2), "") << "for good";
}

TEST_F(Aside, OfTwoTheOneWithMoreOnItOrElseTheLater) {
  end_in_the_middle_of(1, 3, true);
  end_in_the_middle_of(2, 3, true);
  EXPECT_NE(why(3), "");
  EXPECT_EQ(why(1), "");
  EXPECT_EQ(why(2), "");
}

TEST_F(Aside, AServerThatIsKilledBlamesNobodySoon) {
  for (int i = 0; i < 4; ++i) end_in_the_middle_of(2, 2, false);
  EXPECT_EQ(why(2), "");
  end_in_the_middle_of(2, 2, false);
  EXPECT_NE(why(2), "");
}

TEST_F(Aside, AttemptsThatThrowAreCountedToo) {
  log.on_attempt = [](SessionId id) {
    if (id == 2) throw std::runtime_error("out of memory, say");
  };
  start();
  for (int i = 0; i < 20 && why(2).empty(); ++i) {
    worker->trigger(2, Trigger::command);
    settle();
  }
  EXPECT_NE(why(2), "");
  settle();
  EXPECT_EQ(log.aside, std::vector<SessionId>{2});
  EXPECT_EQ(store->troubles().value().at(0).deaths, 2);
}

/// As the pipeline's rooms work: block by block, until somebody has had enough.
void work_for_ever() {
  for (;;) for_blocks(1, 1, 1, [](std::size_t, std::size_t, std::size_t) {});
}

TEST_F(Aside, WorkThatUsesUpItsBudgetTwiceIsNotDoneAThirdTime) {
  schedule.budget_s = 0.01;
  log.on_attempt = [](SessionId id) {
    if (id == 2) work_for_ever();
  };
  start();
  for (int i = 0; i < 20 && why(2).empty(); ++i) {
    worker->trigger(2, Trigger::command);
    settle();
  }
  EXPECT_NE(why(2), "");
  worker->trigger(1, Trigger::command);
  settle();
  settle();
  EXPECT_TRUE(attempted(1)) << "all else goes on";
}

TEST_F(Aside, WorkThatTakesTooLongIsSaid) {
  schedule.stuck_s = 1e-9;
  start();
  while (!worker->pending().idle()) std::this_thread::yield();
  EXPECT_EQ(worker->stuck(), "");
  std::promise<void> begun, may_end;
  log.on_attempt = [&](SessionId id) {
    if (id != 2) return;
    begun.set_value();
    may_end.get_future().wait();
  };
  worker->trigger(2, Trigger::command);
  begun.get_future().wait();
  EXPECT_NE(worker->stuck().find("session 2"), std::string::npos) << worker->stuck();
  may_end.set_value();
  settle();
  EXPECT_EQ(worker->stuck(), "");
}

TEST(WorkWatch, SaysWhatIsStuckAndSinceWhen) {
  const std::chrono::steady_clock::time_point now{};
  EXPECT_EQ(why_stuck(std::nullopt, now, 10), "");
  EXPECT_EQ(why_stuck(WorkPiece{3, 4, now}, now + std::chrono::milliseconds(9999), 10), "");
  EXPECT_EQ(why_stuck(WorkPiece{3, 4, now}, now + std::chrono::seconds(10), 10),
            "merging is stuck: work on sessions 3 and 4 has taken 10 s");
}

TEST_F(Aside, WhatTheOperatorSetsAsideHeCanTakeBack) {
  start();
  ASSERT_TRUE(wait_for([&](auto done) { worker->set_aside(2, "its lidar is loose", std::move(done)); }));
  EXPECT_EQ(why(2), "its lidar is loose");
  start();
  EXPECT_EQ(log.fed[2], 0U);
  ASSERT_TRUE(wait_for([&](auto done) { worker->release(2, std::move(done)); }));
  EXPECT_EQ(log.fed[2], 4U);
  EXPECT_EQ(why(2), "");
  EXPECT_EQ(wait_for([&](auto done) { worker->release(2, std::move(done)); }).error().code, ErrorCode::refused);
  EXPECT_EQ(wait_for([&](auto done) { worker->release(9, std::move(done)); }).error().code, ErrorCode::not_found);
}

TEST_F(Aside, WhatIsDeletedIsGone) {
  start();
  ASSERT_TRUE(wait_for([&](auto done) { worker->remove(2, std::move(done)); }));
  EXPECT_EQ(store->last_keyframe(2).value(), 0U);
  EXPECT_EQ(store->last_keyframe(1).value(), 4U);
  EXPECT_TRUE(store->troubles().value().at(0).deleted);
  start();
  EXPECT_TRUE(worker->view()->sessions.at(2).deleted);
  const auto view = worker->view();
  EXPECT_TRUE(std::none_of(view->atlas.components.begin(), view->atlas.components.end(),
                           [](const Component& c) { return c.id == 2; }));
}

TEST_F(Aside, WhatIsArchivedIsLeftOutUntilItIsRestored) {
  start();
  const auto archive = [&](SessionId id, bool archived) {
    return wait_for([&](auto done) { worker->archive(id, archived, std::move(done)); });
  };
  const auto is_placed = [&](SessionId id) {
    const auto view = worker->view();
    return std::any_of(view->atlas.components.begin(), view->atlas.components.end(),
                       [&](const Component& c) { return placement_in(c, id) != nullptr; });
  };
  EXPECT_EQ(archive(9, true).error().code, ErrorCode::not_found);
  EXPECT_EQ(archive(2, false).error().code, ErrorCode::refused);
  ASSERT_TRUE(archive(2, true));
  EXPECT_EQ(archive(2, true).error().code, ErrorCode::refused);
  EXPECT_TRUE(worker->view()->sessions.at(2).archived);
  EXPECT_FALSE(is_placed(2));
  EXPECT_TRUE(is_placed(1));
  EXPECT_EQ(store->last_keyframe(2).value(), 4U);
  ASSERT_TRUE(write_and_wait(*store, PutKeyframe{2, line_keyframe(5)}));
  worker->keyframes_durable(2, 5);
  start();
  EXPECT_EQ(log.fed[2], 0U) << "the pipeline hears nothing of it";
  EXPECT_FALSE(is_placed(2));
  EXPECT_EQ(wait_for([&](auto done) { worker->freeze(2, true, std::move(done)); }).error().code, ErrorCode::refused);
  EXPECT_EQ(wait_for([&](auto done) { worker->release(2, std::move(done)); }).error().code, ErrorCode::refused);
  ASSERT_TRUE(archive(2, false));
  EXPECT_EQ(log.fed[2], 5U) << "and what came meanwhile";
  EXPECT_EQ(log.back, std::vector<SessionId>{2});
  EXPECT_TRUE(is_placed(2));
  start();
  settle();
  EXPECT_EQ(log.fed[2], 5U);
}

TEST_F(Aside, ASessionIsTakenToAnotherSiteAlsoWhileItIsLeftOut) {
  start();
  settle();
  const std::size_t attempts = log.attempts.size();
  const auto take_to = [&](SessionId id, const std::string& site) {
    return wait_for([&](auto done) { worker->set_site(id, site, std::move(done)); });
  };
  EXPECT_EQ(take_to(9, "north").error().code, ErrorCode::not_found);
  ASSERT_TRUE(take_to(1, "north"));
  EXPECT_EQ(log.sites[1], "north");
  settle();
  EXPECT_GT(log.attempts.size(), attempts) << "it is tried there";
  ASSERT_TRUE(wait_for([&](auto done) { worker->archive(2, true, std::move(done)); }));
  ASSERT_TRUE(take_to(2, "south"));
  EXPECT_EQ(log.sites[2], "") << "the pipeline hears nothing of it";
  ASSERT_TRUE(wait_for([&](auto done) { worker->archive(2, false, std::move(done)); }));
  EXPECT_EQ(log.sites[2], "south");
  log.sites.clear();
  start();
  settle();
  EXPECT_EQ(log.sites[1], "north") << "after a restart, too";
  EXPECT_EQ(log.sites[2], "south");
}

TEST_F(Aside, OneThatIsArchivedAndSetAsideComesBackWhenBothAreTakenBack) {
  start();
  ASSERT_TRUE(wait_for([&](auto done) { worker->set_aside(2, "loose", std::move(done)); }));
  ASSERT_TRUE(wait_for([&](auto done) { worker->archive(2, true, std::move(done)); }));
  ASSERT_TRUE(wait_for([&](auto done) { worker->release(2, std::move(done)); }));
  EXPECT_TRUE(log.back.empty());
  ASSERT_TRUE(wait_for([&](auto done) { worker->archive(2, false, std::move(done)); }));
  EXPECT_EQ(log.back, std::vector<SessionId>{2});
}

TEST_F(Aside, WhatIsFrozenIsSoAfterARestartUntilItIsThawed) {
  start();
  ASSERT_TRUE(wait_for([&](auto done) { worker->freeze(3, true, std::move(done)); }));
  EXPECT_TRUE(worker->view()->sessions.at(3).frozen);
  start();
  settle();
  EXPECT_EQ(log.frozen, std::vector<SessionId>{3});
  EXPECT_TRUE(worker->view()->sessions.at(3).frozen);
  ASSERT_TRUE(wait_for([&](auto done) { worker->freeze(3, false, std::move(done)); }));
  EXPECT_FALSE(worker->view()->sessions.at(3).frozen);
  start();
  settle();
  EXPECT_TRUE(log.frozen.empty());
}

TEST(WorkMark, SaysHowTheProcessBeforeEnded) {
  const TempDir dir;
  const auto file = dir.path() / "merging";
  EXPECT_EQ(WorkMark::open(file)->left().end, WorkMark::End::well);
  {
    auto mark = WorkMark::open(file).value();
    WorkMark::died();
    mark.on(3, 4);
    mark.off();
  }
  EXPECT_EQ(WorkMark::open(file)->left().end, WorkMark::End::well) << "no work, nobody's fault";
  WorkMark::open(file)->on(3, 4);
  const auto after = WorkMark::open(file).value();
  EXPECT_EQ(after.left().end, WorkMark::End::killed);
  EXPECT_EQ(after.left().a, 3);
  EXPECT_EQ(after.left().b, 4);
}

}  // namespace
}  // namespace headframe
