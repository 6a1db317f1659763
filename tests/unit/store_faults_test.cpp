// What a full disk, a broken database and a kill do to the store.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <thread>

#include "server/store/sqlite.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

TEST(StoreFaults, AFullDiskIsWaitedOutAndNothingIsLost) {
  const TempDir dir;
  constexpr std::uint64_t all = 3000;
  std::atomic<std::uint64_t> durable = 0, failed = 0;
  {
    const auto store = open(dir, {.retry_ms = 1});
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
    std::uint64_t before = 0;
    {
      const FileLimit limit(1'000'000);
      for (std::uint64_t i = 1; i <= all; ++i)
        store->write(PutKeyframe{1, line_keyframe(i)},
                     [&](const Result<void>& result) { ++(result ? durable : failed); });
      while (store->load().waits_for.empty()) std::this_thread::yield();
      EXPECT_EQ(keyframes(*store, 1).size(), durable) << "reads go on";
      before = durable;
      EXPECT_LT(before, all);
      EXPECT_EQ(store->load().last_error, store->load().waits_for);
    }
    EXPECT_TRUE(write_and_wait(*store, CompleteSession{1})) << "it goes on by itself";
    EXPECT_EQ(durable, all);
    EXPECT_EQ(failed, 0U);
    EXPECT_EQ(store->load().waits_for, "");
  }
  EXPECT_EQ(keyframes(*open(dir), 1).size(), all);
}

TEST(StoreFaults, ClosedWhileTheDiskIsFullItFailsWhatWaits) {
  const TempDir dir;
  std::uint64_t durable = 0, failed = 0;  // counted by the writer's thread, read when it has ended
  {
    const auto store = open(dir, {.database_bytes = 1'000'000, .retry_ms = 1});
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
    for (std::uint64_t i = 1; i < 3000; ++i)
      store->write(PutKeyframe{1, line_keyframe(i)},
                   [&](const Result<void>& result) { ++(result ? durable : failed); });
    while (store->load().waits_for.empty()) std::this_thread::yield();
    EXPECT_NE(store->load().waits_for.find("disk is full"), std::string::npos) << store->load().waits_for;
  }
  EXPECT_GE(durable, 100U);
  EXPECT_EQ(durable + failed, 2999U);
  const auto store = open(dir);  // room was made
  EXPECT_EQ(keyframes(*store, 1).size(), durable);
  EXPECT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(durable + 1)}));
}

/// Changes the database behind the store's back.
void tamper(const TempDir& dir, const std::string& sql) {
  auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
  ASSERT_TRUE(database);
  const auto done = database->execute(sql);
  ASSERT_TRUE(done) << done.error().message;
}

TEST(StoreFaults, ADatabaseThatCanNotBeWrittenIsNotTriedAgain) {
  const std::vector<std::pair<std::string, std::string>> faults{
      {"DROP TABLE clouds; DROP TABLE keyframes", "no such table"},
      {"PRAGMA writable_schema=ON; UPDATE sqlite_master SET rootpage=999999 WHERE name='keyframes';"
       "PRAGMA schema_version=77",
       "damaged"}};
  for (const auto& [sql, why] : faults) {
    const TempDir dir;
    const auto store = open(dir, {.retry_ms = 1});
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
    EXPECT_EQ(store->load().broken, "");
    tamper(dir, sql);
    const auto failed = write_and_wait(*store, PutKeyframe{1, line_keyframe(1)});
    ASSERT_FALSE(failed);
    EXPECT_NE(failed.error().message.find(why), std::string::npos) << failed.error().message;
    EXPECT_EQ(store->load().broken, failed.error().message);
    EXPECT_EQ(store->load().waits_for, "");
    const auto durable = store->load().durable_writes;
    const auto after = write_and_wait(*store, PutSession{session_record(2, "bee")});
    ASSERT_FALSE(after) << "not even what could be written: order would be lost";
    EXPECT_EQ(after.error().message, failed.error().message);
    EXPECT_EQ(store->load().durable_writes, durable);
    EXPECT_EQ(store->load().queued_bytes, 0U);
  }
}

TEST(StoreFaults, ADamagedRowCostsItselfAlone) {
  for (const char* damage :
       {"stamp_s=stamp_s+1", "T_local_sensor=zeroblob(96)", "T_local_sensor=x'00'", "spaciousness_m=99",
        "q=zeroblob(12)", "q=x''", "w=zeroblob(8)", "place_class=2", "walls=zeroblob(180)", "point_count=7"}) {
    const TempDir dir;
    {
      const auto store = open(dir);
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
      for (std::uint64_t i = 1; i <= 5; ++i) ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(i)}));
      EXPECT_EQ(keyframes(*store, 1).size(), 5U);
      EXPECT_EQ(store->load().damaged_keyframes, 0U);
    }
    tamper(dir, "UPDATE keyframes SET " + std::string(damage) + " WHERE sequence IN (1, 3)");
    const auto store = open(dir);
    const auto all = keyframes(*store, 1);
    ASSERT_EQ(all.size(), 5U) << damage;
    for (const std::uint64_t i : {1, 3}) {
      EXPECT_EQ(all[i - 1].sequence, i) << damage;
      EXPECT_EQ(all[i - 1].T_local_sensor.matrix(), line_keyframe(2).T_local_sensor.matrix()) << "its neighbour's";
      EXPECT_TRUE(all[i - 1].descriptor.q.empty()) << damage;
      EXPECT_EQ(all[i - 1].point_count, 0U) << damage;
    }
    for (const std::uint64_t i : {2, 4, 5})
      EXPECT_EQ(all[i - 1].T_local_sensor.matrix(), line_keyframe(i).T_local_sensor.matrix()) << damage;
    EXPECT_EQ(store->load().damaged_keyframes, 2U);
    ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(6)})) << "and it goes on";
  }
}

TEST(StoreFaults, WhatGoesIntoAFileThatIsGoneIsNotAcknowledged) {
  const auto remove = [](const std::filesystem::path& file) { std::filesystem::remove(file); };
  const auto replace = [](const std::filesystem::path& file) {
    std::filesystem::rename(file, file.string() + ".old");
    std::filesystem::copy(file.string() + ".old", file);
  };
  const std::vector<std::pair<const char*, std::function<void(const std::filesystem::path&)>>> ways{
      {"headframe.db", remove}, {"headframe.db", replace}, {"headframe.db-wal", remove}};
  for (const auto& [name, lose] : ways) {
    const TempDir dir;
    const auto store = open(dir, {.retry_ms = 1});
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
    lose(dir.path() / name);
    const auto lost = write_and_wait(*store, PutKeyframe{1, line_keyframe(1)});
    ASSERT_FALSE(lost) << name;
    EXPECT_NE(lost.error().message.find(std::string(name) + " was removed or replaced"), std::string::npos)
        << lost.error().message;
    EXPECT_EQ(store->load().broken, lost.error().message) << "no robot hears of an ack until it was mended";
  }
}

/// Writes without end; tells each durable sequence through the pipe. Only left by a kill.
[[noreturn]] void write_for_ever(const std::filesystem::path& directory, int pipe) {
  auto store = open_sqlite_store(directory, {.group_ms = 1});
  (*store)->write(PutSession{session_record(1, "ant")}, [](const Result<void>&) {});
  for (std::uint64_t i = 1;; ++i) {
    while ((*store)->load().queued_writes > 200) ::usleep(100);
    (*store)->write(PutKeyframe{1, line_keyframe(i)}, [pipe, i](const Result<void>& result) {
      if (!result || ::write(pipe, &i, sizeof i) != sizeof i) ::_exit(1);
    });
  }
}

TEST(StoreFaults, KillInMidWriteLosesNothingThatWasDurable) {
  const TempDir dir;
  for (int round = 0; round < 3; ++round) {
    std::filesystem::remove_all(dir.path());
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) write_for_ever(dir.path(), ends[1]);
    ::close(ends[1]);
    std::uint64_t told = 0, sequence = 0;
    while (told < 500U * (round + 1) && ::read(ends[0], &sequence, sizeof sequence) == sizeof sequence) told = sequence;
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    while (::read(ends[0], &sequence, sizeof sequence) == sizeof sequence) told = sequence;
    ::close(ends[0]);
    ASSERT_GE(told, 500U);
    const auto store = open(dir);
    const auto all = keyframes(*store, 1);
    EXPECT_GE(all.size(), told);
    for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i].sequence, i + 1);
  }
}

}  // namespace
}  // namespace headframe
