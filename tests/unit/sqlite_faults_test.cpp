// What a full disk and lost files do to SQLite's store.
#include <gtest/gtest.h>
#include <atomic>
#include <functional>
#include <thread>

#include "server/store/sqlite.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

TEST(SqliteFaults, AFullDiskIsWaitedOutAndNothingIsLost) {
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

TEST(SqliteFaults, ClosedWhileTheDiskIsFullItFailsWhatWaits) {
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

TEST(SqliteFaults, WhatGoesIntoAFileThatIsGoneIsNotAcknowledged) {
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

TEST(SqliteFaults, ADatabaseThatIsDamagedIsNotTriedAgain) {
  const TempDir dir;
  const auto store = open(dir, {.retry_ms = 1});
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
  ASSERT_TRUE(database && database->execute("PRAGMA writable_schema=ON; UPDATE sqlite_master SET rootpage=999999 WHERE "
                                            "name='keyframes'; PRAGMA schema_version=77"));
  const auto failed = write_and_wait(*store, PutKeyframe{1, line_keyframe(1)});
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("damaged"), std::string::npos) << failed.error().message;
  EXPECT_EQ(store->load().broken, failed.error().message);
}

}  // namespace
}  // namespace headframe
