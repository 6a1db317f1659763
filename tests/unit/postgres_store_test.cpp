// What only a database behind a connection can do: go away, be another server's, lose what it acknowledged.
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "server/store/postgres_writer.hpp"
#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

constexpr StoreOptions impatient{.group_ms = 1, .retry_ms = 1, .longest_retry_ms = 20};
constexpr const char* of_servers = " FROM pg_stat_activity WHERE application_name = 'headframe-server'";

class PostgresStore : public testing::Test {
 protected:
  void SetUp() override {
    if (test::PostgresCluster::programs().empty()) GTEST_SKIP() << test::PostgresCluster::not_installed;
    cluster = test::PostgresCluster::of_this_process();
    ASSERT_NE(cluster, nullptr);
    home.emplace(Engine::postgres);
  }

  void execute(const std::string& sql) const {
    const auto done = cluster->execute(sql);
    ASSERT_TRUE(done) << done.error().message;
  }
  std::int64_t number(const std::string& sql) const {
    std::int64_t value = -1;
    EXPECT_TRUE(home->database()->each(sql, [&](const Row& row) { value = row.integer(0); }));
    return value;
  }
  std::string open_error(const std::string& url) const {
    const TempDir other;
    const auto store = open_postgres_store(other.path(), url);
    if (store) return "opened";
    EXPECT_EQ(store.error().message.find('\n'), std::string::npos) << store.error().message;
    return store.error().message;
  }

  test::PostgresCluster* cluster = nullptr;
  std::optional<StoreHome> home;
};

TEST_F(PostgresStore, ASecondServerIsRefusedAndToldWhoIsThere) {
  auto store = open(*home);
  const std::string why = open_error(home->url());
  EXPECT_NE(why.find("is in use by another headframe-server, connected from the same machine since 20"),
            std::string::npos)
      << why;
  store.reset();
  EXPECT_EQ(open_error(home->url()), "opened");
}

/// The connection of a server that died may work for a while on what it was sent last: it is waited for.
TEST_F(PostgresStore, AServerThatDiedIsSucceededWhenItsLastCommandIsDone) {
  open(*home).reset();
  PostgresDatabase dead(home->url(), "PostgreSQL");
  ASSERT_TRUE(dead.connect());
  ASSERT_TRUE(take_for_one_server(dead));
  std::thread works([&] { EXPECT_TRUE(dead.execute("SELECT pg_sleep(1); SELECT pg_advisory_unlock_all()")); });
  while (number("SELECT count(*)" + std::string(of_servers) + " AND wait_event = 'PgSleep'") == 0)
    std::this_thread::yield();
  EXPECT_EQ(open_error(home->url()), "opened");
  works.join();
}

TEST_F(PostgresStore, AServerThatStandsByTakesOverWhenTheOtherLetsGo) {
  auto first = open(*home, impatient);
  const TempDir other;
  std::atomic<int> asked = 0, waited = 0;
  PostgresOpening opening;
  opening.standby = StandbyPlan{[&](const std::optional<ServerCard>& active) -> Result<void> {
                                  EXPECT_FALSE(active) << "a store alone tells nobody of itself";
                                  ++asked;
                                  return {};
                                },
                                [&](const Error&, std::chrono::milliseconds) { return ++waited > 0; }};
  Result<std::unique_ptr<Store>> second;
  std::thread opens([&] { second = open_postgres_store(other.path(), home->url(), impatient, opening); });
  while (waited < 3) std::this_thread::yield();
  ASSERT_TRUE(write_and_wait(*first, PutSession{session_record(1, "ant")})) << "it is in nobody's way";
  first.reset();
  opens.join();
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ(asked, 1);
  EXPECT_EQ((*second)->sessions()->size(), 1U);
}

TEST_F(PostgresStore, AServerStandsByOnlyIfItMayAndAsLongAsItIsNotEnded) {
  const auto first = open(*home, impatient);
  const TempDir other;
  PostgresOpening opening;
  opening.standby = StandbyPlan{[](const auto&) { return failure(ErrorCode::refused, "it may not"); },
                                [](const Error&, std::chrono::milliseconds) { return true; }};
  const auto may_not = open_postgres_store(other.path(), home->url(), impatient, opening);
  ASSERT_FALSE(may_not);
  EXPECT_EQ(may_not.error().message, "it may not");
  opening.standby = StandbyPlan{[](const auto&) { return Result<void>(); },
                                [](const Error& why, std::chrono::milliseconds) {
                                  EXPECT_NE(why.message.find("in use by another headframe-server"), std::string::npos);
                                  return false;
                                }};
  const auto ended = open_postgres_store(other.path(), home->url(), impatient, opening);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().message, "it was ended while it stood by");
  ASSERT_TRUE(home->database()->execute("UPDATE schema_version SET version = 1000"));
  const auto older = open_postgres_store(other.path(), home->url(), impatient, opening);
  ASSERT_FALSE(older);
  EXPECT_EQ(older.error().code, ErrorCode::incompatible) << "found out before it waits";
}

TEST_F(PostgresStore, AServerThatHasNothingToWriteTakesItsDatabaseBackAllTheSame) {
  const std::string of_writer = " FROM pg_locks WHERE locktype = 'advisory' AND granted";
  const auto store = open(*home, impatient);
  const std::int64_t before = number("SELECT pid::bigint" + of_writer);
  execute("SELECT pg_terminate_backend(pid)" + of_writer);
  const std::string another = "SELECT count(*)" + of_writer + " AND pid <> " + std::to_string(before);
  while (number(another) == 0) std::this_thread::yield();
  EXPECT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
}

TEST_F(PostgresStore, WhileTheDatabaseIsAwayWritesWaitAndNothingIsLostOrDoubled) {
  constexpr std::uint64_t all = 1500;
  std::atomic<std::uint64_t> durable = 0, failed = 0;
  const auto store = open(*home, impatient);
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  std::uint64_t written = 0;
  for (int round = 0; round < 3; ++round) {
    for (std::uint64_t i = 0; i < all / 3; ++i)
      store->write(PutKeyframe{1, line_keyframe(++written)},
                   [&](const Result<void>& result) { ++(result ? durable : failed); });
    while (durable < written - 400) std::this_thread::yield();
    cluster->kill();
    store->write(PutLabel{1, "written while it is away"}, [](const Result<void>&) {});
    while (store->load().waits_for.empty()) std::this_thread::yield();
    const std::uint64_t before = durable;  // an answer may still have been on its way when it was killed
    EXPECT_NE(store->load().waits_for.find("PostgreSQL, database mine"), std::string::npos) << store->load().waits_for;
    const auto read = store->sessions();
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, ErrorCode::unavailable);
    EXPECT_EQ(durable, before) << "nothing is acknowledged";
    ASSERT_TRUE(cluster->start());
    EXPECT_TRUE(write_and_wait(*store, CompleteSession{1})) << "it goes on by itself";
    while (!store->sessions()) std::this_thread::yield();
    EXPECT_GE(keyframes(*store, 1).size(), before) << "what was acknowledged, and reads go on";
  }
  EXPECT_EQ(durable, all);
  EXPECT_EQ(failed, 0U);
  EXPECT_EQ(store->load().waits_for, "");
  EXPECT_EQ(keyframes(*store, 1).size(), all);
}

/// A commit that is durable, and whose connection ends before it could be answered: PostgreSQL waits for a standby that
/// never comes. What the transaction writes must not be written again: a revision has its number once.
TEST_F(PostgresStore, ACommitWhoseAnswerWasLostIsFoundOut) {
  const auto store = open(*home, impatient);
  for (const SessionId id : {1, 2})
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
  execute("ALTER SYSTEM SET synchronous_standby_names = 'nobody'");
  execute("SELECT pg_reload_conf()");
  std::atomic<bool> enough = false;
  std::thread probe([&] {  // until commits wait: the server takes its new settings in its own time
    for (int i = 0; !enough; ++i) EXPECT_TRUE(cluster->execute("CREATE TABLE probe" + std::to_string(i) + " ()"));
  });
  const std::string waiting = " FROM pg_stat_activity WHERE wait_event = 'SyncRep'";
  while (number("SELECT count(*)" + waiting) == 0) std::this_thread::yield();
  enough = true;
  const Alignment alignment{1, 1, 2, AlignmentState::published, Pose::Identity(), {}};
  std::promise<Result<void>> written;
  store->write(PutMerge{0, 0, {alignment}, Atlas{1, {{1, {{1, Pose::Identity()}, {2, Pose::Identity()}}}}}, {}},
               [&](const Result<void>& done) { written.set_value(done); });
  const std::string of_the_server = waiting + " AND application_name = 'headframe-server'";
  while (number("SELECT count(*)" + of_the_server) == 0) std::this_thread::yield();
  execute("SELECT pg_terminate_backend(pid)" + of_the_server);
  execute("ALTER SYSTEM RESET synchronous_standby_names");
  execute("SELECT pg_reload_conf()");
  probe.join();
  const auto result = written.get_future().get();
  EXPECT_TRUE(result) << result.error().message;
  EXPECT_EQ(number("SELECT count(*) FROM merge_order"), 1) << "written once";
  EXPECT_TRUE(write_and_wait(*store, PutMerge{0, 0, {alignment}, Atlas{2, {}}, {}})) << "and it goes on";
  EXPECT_EQ(number("SELECT count(*) FROM merge_order"), 2);
}

TEST_F(PostgresStore, AServerWhoseDatabaseAnotherTookOverWritesNothing) {
  const auto store = open(*home, impatient);
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  ASSERT_TRUE(home->database()->execute("UPDATE writer SET owner = owner + 1"));
  const auto refused = write_and_wait(*store, PutKeyframe{1, line_keyframe(1)});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("another headframe-server has taken"), std::string::npos)
      << refused.error().message;
  EXPECT_EQ(store->load().broken, refused.error().message);
  EXPECT_EQ(number("SELECT count(*) FROM keyframes"), 0);
}

TEST_F(PostgresStore, ADatabaseThatLacksWhatItAcknowledgedIsNotGoneOnWith) {
  const auto store = open(*home, impatient);
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(1)}));
  ASSERT_TRUE(home->database()->execute("DELETE FROM keyframes; UPDATE writer SET commits = commits - 1"));
  execute("SELECT pg_terminate_backend(pid)" + std::string(of_servers));
  const auto refused = write_and_wait(*store, PutKeyframe{1, line_keyframe(2)});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("of 2 commits that were acknowledged it has 1"), std::string::npos)
      << refused.error().message;
  EXPECT_EQ(store->load().broken, refused.error().message);
}

TEST_F(PostgresStore, WhatCanNotBeUsedIsSaidInOneLine) {
  EXPECT_NE(open_error("postgresql:///nowhere?host=/nowhere").find("No such file"), std::string::npos);
  EXPECT_NE(open_error("postgresql://ant:secret@[::").find("is not understood"), std::string::npos);
  EXPECT_NE(open_error(cluster->url("absent")).find("\"absent\" does not exist"), std::string::npos);
  const std::string nobody = open_error("postgresql://ant:secret@/mine1?host=" + cluster->folder().string());
  EXPECT_NE(nobody.find("role \"ant\" does not exist"), std::string::npos) << nobody;
  EXPECT_EQ(nobody.find("secret"), std::string::npos) << nobody;
  execute("CREATE DATABASE latin ENCODING 'LATIN1' TEMPLATE template0");
  EXPECT_NE(open_error(cluster->url("latin")).find("encoding LATIN1"), std::string::npos);
}

TEST_F(PostgresStore, APostgresThatForgetsInAPowerCutIsRefused) {
  execute("ALTER SYSTEM SET fsync = off");
  execute("SELECT pg_reload_conf()");
  std::string why;
  do why = open_error(home->url());
  while (why == "opened");  // the server takes its new settings in its own time
  EXPECT_NE(why.find("set fsync = on"), std::string::npos) << why;
  execute("ALTER SYSTEM RESET fsync");
  execute("SELECT pg_reload_conf()");
  while (open_error(home->url()) != "opened") std::this_thread::yield();
}

TEST_F(PostgresStore, AFolderThatHoldsADatabaseOfItsOwnIsRefused) {
  ASSERT_TRUE(open_sqlite_store(home->path()));
  const auto refused = home->try_open();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::refused);
  EXPECT_NE(refused.error().message.find("headframe.db"), std::string::npos) << refused.error().message;
}

TEST_F(PostgresStore, ADatabaseOfBeforeKeyframesMovedIsBroughtUp) {
  ASSERT_TRUE(write_and_wait(*open(*home), PutSession{session_record(1, "ant")}));
  ASSERT_TRUE(home->database()->execute(
      "DROP TABLE moved_poses; DROP TABLE pose_updates;"
      "ALTER TABLE sessions DROP COLUMN pose_update;"
      "ALTER TABLE servers DROP COLUMN relayed, DROP COLUMN loopback;"
      "ALTER TABLE servers DROP COLUMN searched, DROP COLUMN searches_a, DROP COLUMN searches_b;"
      "DROP TABLE pair_work;"
      "ALTER TABLE self_likeness DROP COLUMN similar_places, DROP COLUMN places;"
      "UPDATE schema_version SET version = version - 5"));
  const auto store = open(*home);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->sessions()->at(0).pose_update, 0U);
  ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(1)}));
  ASSERT_TRUE(write_and_wait(*store, PutPoses{1, 1, {{1, {1, {{1, Pose::Identity()}}}}}}));
  EXPECT_EQ(store->new_poses(1)->poses.size(), 1U);
}

TEST_F(PostgresStore, ANewerSchemaIsRefused) {
  open(*home).reset();
  ASSERT_TRUE(home->database()->execute("UPDATE schema_version SET version = version + 1"));
  const auto refused = home->try_open();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::incompatible);
}

/// More than the connection takes at once, both ways.
TEST_F(PostgresStore, AGreatMergeIsWrittenWhole) {
  const auto store = open(*home);
  PutMerge merge;
  for (SessionId id = 1; id <= 40; ++id)
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
  for (SessionId a = 1; a <= 40; ++a)
    for (SessionId b = a + 1; b <= 40; ++b)
      merge.changed.push_back({static_cast<AlignmentId>(merge.changed.size()) + 1, a, b, {}, Pose::Identity(), {}});
  ASSERT_TRUE(write_and_wait(*store, merge));
  EXPECT_EQ(store->merge()->alignments.size(), merge.changed.size());
}

}  // namespace
}  // namespace headframe
