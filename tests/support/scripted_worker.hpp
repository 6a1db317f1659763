#pragma once
// The merge worker with a pipeline that does what a test says, on a real store.

#include <gtest/gtest.h>

#include <algorithm>
#include <future>

#include "server/merge_worker/merge_worker.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {

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
  std::set<SessionId> awaited, completed, awaited_no_more, ask_where;
  std::uint64_t restored_revision = 0;
  std::function<AttemptReport(SessionId, CloudSource&)> on_attempt = [](SessionId, CloudSource&) {
    return AttemptReport();
  };
  std::function<Result<AttemptReport>(AlignmentId, Decision)> on_decision = [](AlignmentId, Decision) {
    return AttemptReport();
  };
  std::function<Result<AttemptReport>(SessionId)> on_anchor = [](SessionId) { return AttemptReport(); };
  std::function<SessionLocalization(SessionId)> on_localization = [](SessionId) { return SessionLocalization(); };
  Atlas atlas;
  std::vector<Alignment> alignments;
  std::vector<SessionId> anchors;
  std::vector<std::pair<SessionId, std::vector<Keyframe>>> moved;
  bool moves_anything = true;
  std::function<void(AttemptReport&)> on_move = [](AttemptReport&) {};
  std::uint64_t cut_from = UINT64_MAX;  // a session with this keyframe is cut there

  std::size_t attempted() {
    const std::lock_guard lock(mutex);
    return attempts.size();
  }
};

class ScriptedPipeline : public Pipeline {
 public:
  explicit ScriptedPipeline(Script& script) : script_(script) {}
  void add_session(SessionId, const FamilyId&, const std::string&) override {}
  void add_keyframe(SessionId id, Keyframe keyframe) override {
    const std::lock_guard lock(script_.mutex);
    script_.keyframes[id].push_back(keyframe.sequence);
  }
  SessionCut cut(SessionId id) const override {
    const std::lock_guard lock(script_.mutex);
    const auto& known = script_.keyframes[id];
    return !known.empty() && known.back() >= script_.cut_from
               ? SessionCut{script_.cut_from, false, "its odometry jumps"}
               : SessionCut();
  }
  AttemptReport move_session(SessionId id, const std::vector<Keyframe>& keyframes) override {
    const std::lock_guard lock(script_.mutex);
    script_.moved.emplace_back(id, keyframes);
    AttemptReport report;
    report.atlas_changed = script_.moves_anything;
    script_.on_move(report);
    return report;
  }
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource&) override {
    const std::lock_guard lock(script_.mutex);
    script_.prepared.push_back({keyframe, script_.attempts.size()});
  }
  void complete_session(SessionId id) override {
    const std::lock_guard lock(script_.mutex);
    script_.completed.insert(id);
  }
  void await_no_more(SessionId id) override {
    const std::lock_guard lock(script_.mutex);
    script_.awaited_no_more.insert(id);
  }
  void await_attempt(SessionId id) override { script_.awaited.insert(id); }
  Result<AttemptReport> decide(AlignmentId id, Decision decision) override { return script_.on_decision(id, decision); }
  void restore(std::vector<Alignment> alignments, std::uint64_t revision, std::vector<DecisionRecord>,
               std::vector<SessionId> anchors) override {
    script_.anchors = std::move(anchors);
    script_.alignments = std::move(alignments);
    script_.restored_revision = revision;
  }
  Result<AttemptReport> anchor(SessionId id) override { return script_.on_anchor(id); }
  bool ask_where(SessionId id, bool asks) override {
    const std::lock_guard lock(script_.mutex);
    asks ? (void)script_.ask_where.insert(id) : (void)script_.ask_where.erase(id);
    return true;
  }
  SessionLocalization localization(SessionId id) const override { return script_.on_localization(id); }
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
  std::vector<Component> changed, provisional;
  std::vector<Withdrawal> withdrawn;
  std::function<void()> on_publish = [] {};

  void request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) override {
    const std::lock_guard lock(mutex);
    for (const std::uint64_t sequence : sequences) requested.push_back({session, sequence});
  }
  void publish(const Atlas&, const std::vector<Component>& components, const std::vector<Withdrawal>& merges) override {
    on_publish();
    const std::lock_guard lock(mutex);
    changed = components;
    withdrawn = merges;
  }
  void tell_provisional(const Atlas&, const std::vector<Component>& components) override {
    const std::lock_guard lock(mutex);
    provisional = components;
  }
  std::vector<std::pair<SessionId, SessionLocalization>> localizations;
  void tell_localization(SessionId session, const SessionLocalization& localization) override {
    const std::lock_guard lock(mutex);
    localizations.emplace_back(session, localization);
  }
  std::vector<SessionId> moved;
  void tell_moved(SessionId session) override {
    const std::lock_guard lock(mutex);
    moved.push_back(session);
  }
  std::map<SessionId, SessionCut> cuts;
  void tell_cut(SessionId session, const SessionCut& cut) override {
    const std::lock_guard lock(mutex);
    cuts[session] = cut;
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
    if (!attempted) return;
    ASSERT_TRUE(eventually([&] { return idle(); })) << "all is back";
  }

  bool idle() const { return worker->pending().idle(); }

  TempDir dir;
  Script script;
  FakeRobots robots;
  std::unique_ptr<Store> store;
  std::unique_ptr<MergeWorker> worker;  // gone before the others
};

}  // namespace headframe
