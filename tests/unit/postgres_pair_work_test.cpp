// Pairs of sessions that standby servers search for the active one, through a real PostgreSQL.
#include "server/store/postgres_pair_work.hpp"

#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "server/support/parallel.hpp"
#include "tests/support/both_stores.hpp"

namespace headframe {
namespace {

using Turn = PairHelpers::Turn;

PairTask task(SessionId a, SessionId b, char data = 'x') {
  return {a, b, 10, 20, true, false, std::string(32, static_cast<char>(a)) + std::string(32, data)};
}

class PostgresPairWork : public testing::Test {
 protected:
  void SetUp() override {
    if (test::PostgresCluster::programs().empty()) GTEST_SKIP() << test::PostgresCluster::not_installed;
    home.emplace(Engine::postgres);
    open(*home).reset();
    active.emplace(home->url(), "PostgreSQL", [] { return true; });
  }

  PostgresPairQueue queue(std::int64_t self, double lease_s = 600) const {
    return {home->url(), "PostgreSQL", self, lease_s};
  }
  std::int64_t rows() const {
    std::int64_t count = -1;
    EXPECT_TRUE(
        home->database()->each("SELECT count(*) FROM pair_work", [&](const Row& row) { count = row.integer(0); }));
    return count;
  }

  std::optional<StoreHome> home;
  std::optional<PostgresPairHelpers> active;
};

TEST_F(PostgresPairWork, TwoServersNeverTakeTheSamePair) {
  std::vector<PairTask> tasks;
  for (SessionId b = 2; b <= 101; ++b) tasks.push_back(task(1, b));
  active->announce(tasks);
  std::array<std::vector<SessionId>, 3> taken;
  std::vector<std::thread> servers;
  for (std::size_t i = 0; i < taken.size(); ++i)
    servers.emplace_back([&, i] {
      PostgresPairQueue own = queue(static_cast<std::int64_t>(i) + 1);
      while (const auto next = own.take()) taken[i].push_back(next->b);
    });
  while (const auto next = active->claim()) taken[0].push_back(next->b);
  for (std::thread& server : servers) server.join();
  std::multiset<SessionId> all;
  for (const auto& some : taken) all.insert(some.begin(), some.end());
  EXPECT_EQ(all.size(), 100U);
  EXPECT_EQ(std::set<SessionId>(all.begin(), all.end()).size(), 100U);
}

TEST_F(PostgresPairWork, AResultComesBackOnceAndTheTaskAsItWas) {
  PostgresPairQueue standby = queue(1);
  active->announce({task(1, 2), task(3, 3)});
  const auto first = standby.take(), second = standby.take();
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(standby.take());
  EXPECT_EQ(first->b, 2) << "in the order of the announcement";
  EXPECT_EQ(first->keyframes_a, 10U);
  EXPECT_EQ(first->keyframes_b, 20U);
  EXPECT_TRUE(first->complete_a);
  EXPECT_FALSE(first->complete_b);
  EXPECT_EQ(first->digest, task(1, 2).digest);
  EXPECT_EQ(active->ask(task(1, 2)).turn, Turn::others);
  const std::string result("found\0\xff", 7);
  standby.answer(*first, result);
  standby.answer(*second, "");
  const auto answer = active->ask(task(1, 2));
  EXPECT_EQ(answer.turn, Turn::done);
  EXPECT_EQ(answer.result, result);
  EXPECT_EQ(active->ask(task(3, 3)).turn, Turn::mine) << "the search failed";
  EXPECT_EQ(active->ask(task(1, 2)).turn, Turn::mine) << "it is not there any more";
  EXPECT_EQ(rows(), 0);
}

TEST_F(PostgresPairWork, WhatTheActiveServerComputesNobodyElseTakes) {
  PostgresPairQueue standby = queue(1);
  active->announce({task(1, 2), task(1, 3)});
  EXPECT_EQ(active->ask(task(1, 2)).turn, Turn::mine);
  EXPECT_EQ(active->claim()->b, 3);
  EXPECT_FALSE(active->claim());
  EXPECT_FALSE(standby.take());
}

TEST_F(PostgresPairWork, AnEndedLeaseIsTakenAgainAndWaitedForNoLonger) {
  PostgresPairQueue killed = queue(1, 0.2), other = queue(2);
  active->announce({task(1, 2), task(1, 3)});
  ASSERT_EQ(killed.take()->b, 2);
  ASSERT_EQ(killed.take()->b, 3);
  EXPECT_EQ(active->wait(task(1, 2)).turn, Turn::mine) << "nobody answered before the lease ended";
  std::optional<PairTask> again;
  while (!(again = other.take())) std::this_thread::yield();
  EXPECT_EQ(again->b, 3);
  killed.answer(*again, "late");
  EXPECT_EQ(active->ask(task(1, 3)).result, "late") << "a result is one, whoever had the lease";
}

TEST_F(PostgresPairWork, AWaitEndsWithTheResultOrWithTheWork) {
  PostgresPairQueue standby = queue(1);
  active->announce({task(1, 2), task(1, 3)});
  const auto taken = standby.take();
  std::thread answers([&] { standby.answer(*taken, "found"); });
  EXPECT_EQ(active->wait(task(1, 2)).result, "found");
  answers.join();
  ASSERT_TRUE(standby.take());
  std::atomic<bool> over = true;
  const Cancellable cancellable(over);
  EXPECT_THROW(active->wait(task(1, 3)), Cancelled);
}

TEST_F(PostgresPairWork, AnnouncedAgainItKeepsItsResultUnlessTheDataChanged) {
  PostgresPairQueue standby = queue(1);
  active->announce({task(1, 2), task(1, 3)});
  standby.answer(*standby.take(), "found");
  standby.answer(*standby.take(), "found");
  active->announce({task(1, 2), task(1, 3, 'y')});
  EXPECT_EQ(active->ask(task(1, 2)).result, "found");
  EXPECT_EQ(active->ask(task(1, 3)).turn, Turn::mine) << "of the earlier data nothing is left";
  EXPECT_EQ(standby.take()->digest, task(1, 3, 'y').digest);
}

TEST_F(PostgresPairWork, TheLatestAttemptGoesFirstAndTheTableStaysSmall) {
  PostgresPairQueue standby = queue(1);
  active->announce({task(1, 2)});
  active->announce({task(5, 6), task(5, 7)});
  EXPECT_EQ(standby.take()->b, 6);
  active->withdraw({task(5, 7)});
  EXPECT_EQ(standby.take()->b, 2);
  std::vector<PairTask> many;
  for (SessionId b = 10; b < 500; ++b) many.push_back(task(9, b));
  active->announce(many);
  EXPECT_EQ(rows(), static_cast<std::int64_t>(PostgresPairHelpers::most_rows));
  PostgresPairHelpers next(home->url(), "PostgreSQL", [] { return true; });
  next.announce({task(1, 2)});
  EXPECT_EQ(rows(), 1) << "who becomes active forgets what an earlier server asked for";
}

TEST_F(PostgresPairWork, WithoutTheTableNobodyHelps) {
  PostgresPairQueue standby = queue(1);
  ASSERT_TRUE(home->database()->execute("DROP TABLE pair_work"));
  active->announce({task(1, 2)});
  EXPECT_FALSE(standby.take());
  EXPECT_EQ(active->ask(task(1, 2)).turn, Turn::mine);
  EXPECT_FALSE(active->claim());
  EXPECT_EQ(active->wait(task(1, 2)).turn, Turn::mine);
}

TEST_F(PostgresPairWork, AnAnnouncementWakesWhoWaits) {
  PostgresPairQueue standby = queue(1);
  EXPECT_FALSE(standby.wait(std::chrono::milliseconds(0)));  // from now on it listens
  active->announce({task(1, 2)});
  EXPECT_TRUE(standby.wait(std::chrono::seconds(60)));
}

}  // namespace
}  // namespace headframe
