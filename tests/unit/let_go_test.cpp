// Clouds that are let go so that others find room, over both databases: what stays, and what a full disk and a kill do.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

using LetGoOfClouds = OverBothStores;
OVER_BOTH_STORES(LetGoOfClouds);

using Sequences = std::vector<std::uint64_t>;

/// A session of keyframes that have clouds of so many bytes.
void fill(Store& store, std::uint64_t keyframes, std::size_t cloud_bytes) {
  ASSERT_TRUE(write_and_wait(store, PutSession{session_record(1, "ant")}));
  for (std::uint64_t i = 1; i <= keyframes; ++i) {
    ASSERT_TRUE(write_and_wait(store, PutKeyframe{1, line_keyframe(i)}));
    ASSERT_TRUE(write_and_wait(store, PutCloud{{1, i}, std::string(cloud_bytes, 'c')}));
  }
}

TEST_P(LetGoOfClouds, TakesCloudsAndNothingElseAndTakesNoneOfThemAgain) {
  const StoreHome home(GetParam());
  {
    const auto store = open(home);
    fill(*store, 3, 100);
    EXPECT_EQ(store->cloud_sizes(1)->at(1).bytes, 100U);
    ASSERT_TRUE(write_and_wait(*store, LetGo{{{1, 1}, {1, 3}}}));
    ASSERT_TRUE(write_and_wait(*store, LetGo{{{1, 1}, {7, 1}}})) << "again, and of no session";
  }
  const auto store = open(home);
  ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, 3}, "sent again"})) << "its robot is done with it";
  EXPECT_EQ(store->cloud_sequences(1).value(), Sequences{2});
  EXPECT_EQ(store->let_go(1).value(), (Sequences{1, 3}));
  EXPECT_EQ(store->let_go(7).value(), Sequences{});
  EXPECT_EQ(store->cloud({1, 3}).error().code, ErrorCode::not_found);
  EXPECT_EQ(store->cloud({1, 2}).value(), std::string(100, 'c'));
  ASSERT_EQ(store->cloud_sizes(1)->size(), 1U);
  const auto all = keyframes(*store, 1);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[2].T_local_sensor.matrix(), line_keyframe(3).T_local_sensor.matrix());
  EXPECT_EQ(all[2].descriptor.q, line_keyframe(3).descriptor.q);
  EXPECT_EQ(all[2].walls.code, line_keyframe(3).walls.code);
  ASSERT_TRUE(write_and_wait(*store, PutTrouble{{1, 0, 0, "away", true}})) << "and its session can be deleted";
  EXPECT_EQ(store->let_go(1).value(), Sequences{});
}

TEST_P(LetGoOfClouds, SaysHowMuchRoomThereIs) {
  const StoreHome home(GetParam());
  const bool postgres = GetParam() == Engine::postgres;
  const std::uint64_t most = 8UL << 20;
  const auto store = open(home, postgres ? StoreOptions{.clouds_bytes = most} : StoreOptions{.database_bytes = most});
  fill(*store, 20, 100'000);
  const std::uint64_t before = store->free_bytes().value().value();
  EXPECT_LE(before, most - 2'000'000);
  ASSERT_TRUE(write_and_wait(*store, LetGo{{{1, 1}, {1, 2}, {1, 3}}}));
  const std::uint64_t after = store->free_bytes().value().value();
  EXPECT_NEAR(static_cast<double>(after - before), 300'000.0, postgres ? 0 : 5.0 * 16384);
}

TEST(LetGoOfClouds, BesideSqliteTheDiskTellsWhatIsFree) {
  const TempDir dir;
  const auto store = open(dir);
  const auto free = store->free_bytes();
  ASSERT_TRUE(free && *free) << "of SQLite the disk tells";
  EXPECT_GT(**free, 0U);
}

TEST(LetGoOfClouds, GoesBeforeWhatWaitsForAFullDisk) {
  const TempDir dir;
  const auto store = open(dir, {.database_bytes = 2UL << 20, .retry_ms = 1, .longest_retry_ms = 1});
  fill(*store, 10, 100'000);
  ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(11)}));
  std::promise<Result<void>> durable;
  store->write(PutCloud{{1, 11}, std::string(1'000'000, 'n')}, [&](const auto& done) { durable.set_value(done); });
  auto written = durable.get_future();
  while (store->load().waits_for.empty()) std::this_thread::yield();
  ASSERT_TRUE(write_and_wait(*store, LetGo{{{1, 1}}})) << "too little: the other waits on";
  EXPECT_EQ(written.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  LetGo rest;
  for (std::uint64_t i = 2; i <= 10; ++i) rest.clouds.push_back({1, i});
  ASSERT_TRUE(write_and_wait(*store, rest));
  EXPECT_TRUE(written.get());
  EXPECT_EQ(store->cloud_sequences(1).value(), Sequences{11});
}

/// Lets clouds go four at a time; tells of each four through the pipe. Ends by itself, if nobody kills it.
[[noreturn]] void let_all_go(const StoreHome& home, std::uint64_t keyframes, int pipe) {
  auto store = home.try_open({.group_ms = 0});
  for (std::uint64_t i = 1; i + 3 <= keyframes; i += 4) {
    if (!write_and_wait(**store, LetGo{{{1, i}, {1, i + 1}, {1, i + 2}, {1, i + 3}}})) ::_exit(1);
    if (::write(pipe, &i, sizeof i) != sizeof i) ::_exit(1);
  }
  ::_exit(0);
}

TEST_P(LetGoOfClouds, AKillInTheMiddleLeavesEachEitherHereOrGone) {
  constexpr std::uint64_t keyframe_count = 200;
  const StoreHome home(GetParam());
  fill(*open(home), keyframe_count, 2000);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) let_all_go(home, keyframe_count, ends[1]);
  ::close(ends[1]);
  std::uint64_t told = 0;
  for (int i = 0; i < 20; ++i) ASSERT_EQ(::read(ends[0], &told, sizeof told), static_cast<ssize_t>(sizeof told));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  while (::read(ends[0], &told, sizeof told) == sizeof told) continue;
  ::close(ends[0]);
  const auto store = open(home);
  const Sequences gone = store->let_go(1).value(), here = store->cloud_sequences(1).value();
  EXPECT_GE(gone.size(), told + 3) << "what was told is durable";
  EXPECT_EQ(gone.size() % 4, 0U) << "nothing is half done";
  EXPECT_EQ(gone.size() + here.size(), keyframe_count);
  for (std::size_t i = 0; i < gone.size(); ++i) ASSERT_EQ(gone[i], i + 1);
  EXPECT_EQ(keyframes(*store, 1).size(), keyframe_count);
}

}  // namespace
}  // namespace headframe
