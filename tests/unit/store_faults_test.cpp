// What a broken database, a damaged row and a kill do to the store, over both databases.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

using StoreFaults = OverBothStores;
OVER_BOTH_STORES(StoreFaults);

/// Changes the database behind the store's back.
void tamper(const StoreHome& home, const std::string& sql) {
  const auto done = home.database()->execute(sql);
  ASSERT_TRUE(done) << done.error().message;
}

TEST_P(StoreFaults, ADatabaseThatCanNotBeWrittenIsNotTriedAgain) {
  const StoreHome home(GetParam());
  const auto store = open(home, {.retry_ms = 1});
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  EXPECT_EQ(store->load().broken, "");
  tamper(home, std::string(GetParam() == Engine::postgres ? "SET search_path = headframe;" : "") +
                   "DROP TABLE clouds; DROP TABLE keyframes");
  const auto failed = write_and_wait(*store, PutKeyframe{1, line_keyframe(1)});
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("keyframes"), std::string::npos) << failed.error().message;
  EXPECT_EQ(store->load().broken, failed.error().message);
  EXPECT_EQ(store->load().waits_for, "");
  const auto durable = store->load().durable_writes;
  const auto after = write_and_wait(*store, PutSession{session_record(2, "bee")});
  ASSERT_FALSE(after) << "not even what could be written: order would be lost";
  EXPECT_EQ(after.error().message, failed.error().message);
  EXPECT_EQ(store->load().durable_writes, durable);
  EXPECT_EQ(store->load().queued_bytes, 0U);
}

TEST_P(StoreFaults, ADamagedRowCostsItselfAlone) {
  const auto zeros = [&](int count) {
    const std::string hex(static_cast<std::size_t>(2 * count), '0');
    return GetParam() == Engine::sqlite ? "x'" + hex + "'" : "'\\x" + hex + "'";
  };
  const std::string pose = "T_local_sensor=", walls = "walls=";
  for (const std::string& damage :
       {std::string("stamp_s=stamp_s+1"), pose + zeros(96), pose + zeros(1), std::string("spaciousness_m=99"),
        "q=" + zeros(12), "q=" + zeros(0), "w=" + zeros(8), std::string("place_class=2"), walls + zeros(180),
        std::string("point_count=7")}) {
    const StoreHome dir(GetParam());
    {
      const auto store = open(dir);
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
      for (std::uint64_t i = 1; i <= 5; ++i) ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(i)}));
      EXPECT_EQ(keyframes(*store, 1).size(), 5U);
      EXPECT_EQ(store->load().damaged_keyframes, 0U);
    }
    tamper(dir, "UPDATE keyframes SET " + damage + " WHERE sequence IN (1, 3)");
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

/// Writes without end; tells each durable sequence through the pipe. Only left by a kill.
[[noreturn]] void write_for_ever(const StoreHome& home, int pipe) {
  auto store = home.try_open({.group_ms = 1});
  (*store)->write(PutSession{session_record(1, "ant")}, [](const Result<void>&) {});
  for (std::uint64_t i = 1;; ++i) {
    while ((*store)->load().queued_writes > 200) ::usleep(100);
    (*store)->write(PutKeyframe{1, line_keyframe(i)}, [pipe, i](const Result<void>& result) {
      if (!result || ::write(pipe, &i, sizeof i) != sizeof i) ::_exit(1);
    });
  }
}

TEST_P(StoreFaults, KillInMidWriteLosesNothingThatWasDurable) {
  for (int round = 0; round < 3; ++round) {
    const StoreHome dir(GetParam());
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) write_for_ever(dir, ends[1]);
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
