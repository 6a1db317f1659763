// A migration that is killed in the middle: nothing half done looks whole, and it can be begun again.
#include <gtest/gtest.h>

#include <future>

#include "server/store/sqlite_store.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/postgres_cluster.hpp"
#include "tests/support/stores.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

Result<Process> start_migration(const std::string& from, const std::string& to) {
  return Process::start({program("headframe-server"), "--migrate", from, to});
}

/// Kills it when clouds, most of what there is, are on their way.
void kill_halfway(const std::string& from, const std::string& to) {
  auto migration = start_migration(from, to);
  ASSERT_TRUE(migration) << migration.error().message;
  auto line = migration->read_line(30s);
  while (line && line->find("clouds: 0 of") == std::string::npos) line = migration->read_line(30s);
  ASSERT_TRUE(line) << line.error().message;
  migration->signal(SIGKILL);
  const auto ended = migration->wait(10s);
  ASSERT_TRUE(ended && ended->status == 128 + SIGKILL) << "it was quicker than the kill: give it more to do";
}

void run_whole(const std::string& from, const std::string& to) {
  auto migration = start_migration(from, to);
  ASSERT_TRUE(migration) << migration.error().message;
  const auto ended = migration->wait(60s);
  ASSERT_TRUE(ended && ended->status == 0) << ended->output;
  EXPECT_NE(ended->output.find("read again and found the same"), std::string::npos) << ended->output;
}

TEST(Migration, KilledInTheMiddleItLeavesNothingThatLooksWhole) {
  if (PostgresCluster::programs().empty()) GTEST_SKIP() << PostgresCluster::not_installed;
  const auto cluster = PostgresCluster::make();
  ASSERT_TRUE(cluster) << cluster.error().message;
  const std::string url = (*cluster)->make_database().value();
  const ScratchFolder scratch;
  const auto data = scratch.path() / "data", back = scratch.path() / "back";
  constexpr std::uint64_t count = 300;
  {
    const auto store = open_sqlite_store(data);
    ASSERT_TRUE(store);
    ASSERT_TRUE(write_and_wait(**store, PutSession{session_record(1, "ant")}));
    for (std::uint64_t i = 1; i <= count; ++i) {
      (*store)->write(PutKeyframe{1, line_keyframe(i)}, [](const Result<void>&) {});
      (*store)->write(PutCloud{{1, i}, std::string(100'000, static_cast<char>(i))}, [](const Result<void>&) {});
    }
  }
  kill_halfway("sqlite:" + data.string(), url);
  EXPECT_TRUE(open_sqlite_store(data)) << "what was to be moved is as it was";
  run_whole("sqlite:" + data.string(), url);
  kill_halfway(url, "sqlite:" + back.string());
  EXPECT_FALSE(std::filesystem::exists(back / "headframe.db"));
  run_whole(url, "sqlite:" + back.string());
  const auto store = open_sqlite_store(back);
  ASSERT_TRUE(store) << store.error().message;
  EXPECT_EQ(keyframes(**store, 1).size(), count);
  EXPECT_EQ((*store)->cloud_sequences(1)->size(), count);
}

TEST(Migration, TakesOneOfEachKind) {
  for (const auto& [from, to] :
       {std::pair{"sqlite:/nowhere", "sqlite:/elsewhere"}, std::pair{"postgresql://a/b", "mysql://a/b"}}) {
    auto migration = start_migration(from, to);
    ASSERT_TRUE(migration);
    const auto ended = migration->wait(30s);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->status, 2);
    EXPECT_NE(ended->output.find("--migrate takes sqlite:DIR and postgresql://"), std::string::npos) << ended->output;
  }
}

}  // namespace
}  // namespace headframe::test
