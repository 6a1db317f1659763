#include "server/support/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

namespace headframe {
namespace {

/// How often each of the items was visited.
std::vector<int> visits(std::size_t items, std::size_t block, int threads) {
  std::vector<int> seen(items, 0);
  for_blocks(items, block, threads, [&](std::size_t begin, std::size_t end, std::size_t b) {
    EXPECT_EQ(begin, b * block);
    for (std::size_t i = begin; i < end; ++i) ++seen[i];
  });
  return seen;
}

TEST(Parallel, VisitsEveryItemOnce) {
  for (int threads : {-1, 0, 1, 2, 3, 64})
    for (std::size_t items : {0U, 1U, 7U, 8U, 9U, 1000U})
      EXPECT_EQ(visits(items, 8, threads), std::vector<int>(items, 1)) << threads << " " << items;
}

TEST(Parallel, CallsMayBeNestedAndComeFromManyThreads) {
  std::atomic<int> count = 0;
  const auto outer = [&] {
    for_blocks(50, 1, 4, [&](std::size_t, std::size_t, std::size_t) {
      for_blocks(50, 1, 4, [&](std::size_t, std::size_t, std::size_t) { ++count; });
    });
  };
  { const std::jthread a(outer), b(outer), c(outer); }
  EXPECT_EQ(count, 3 * 2500);
}

TEST(Parallel, AHelperComesToEveryCallHoweverSoonAfterTheLast) {
  for (int i = 0; i < 5000; ++i) {
    if (i % 10 == 0)  // longer than helpers look for work before they sleep
      for (const auto until = std::chrono::steady_clock::now() + std::chrono::microseconds(i / 10);
           std::chrono::steady_clock::now() < until;) {
      }
    std::atomic<int> inside = 0;
    for_blocks(2, 1, 2, [&](std::size_t, std::size_t, std::size_t) {
      ++inside;
      while (inside < 2) std::this_thread::yield();  // for the other block, which only a helper can begin
    });
  }
}

TEST(Parallel, CancelledWorkEndsBeforeItsNextBlock) {
  for (const int threads : {1, 3}) {
    std::atomic<bool> flag = false;
    std::atomic<int> done = 0;
    const auto work = [&] {
      for_blocks(1000, 1, threads, [&](std::size_t, std::size_t, std::size_t) {
        ++done;
        flag = true;
      });
    };
    {
      const Cancellable cancellable(flag);
      EXPECT_THROW(work(), Cancelled);
      EXPECT_LE(done, threads);
    }
    EXPECT_NO_THROW(work()) << "only where it was asked for";
  }
}

TEST(Parallel, AnExceptionReachesTheCallerAndThePoolLivesOn) {
  for (int i = 0; i < 100; ++i)
    EXPECT_THROW(for_blocks(100, 1, 4,
                            [](std::size_t begin, std::size_t, std::size_t) {
                              if (begin % 10 == 3) throw std::runtime_error("block");
                            }),
                 std::runtime_error);
  EXPECT_EQ(visits(100, 3, 4), std::vector<int>(100, 1));
}

}  // namespace
}  // namespace headframe
