#include "server/net/fair_pool.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

namespace headframe {
namespace {

TEST(FairPool, OwnersTakeTurnsHoweverMuchOneSubmits) {
  std::promise<void> go, all;
  std::string order;
  {
    FairPool pool(1);
    pool.submit("gate", [&] { go.get_future().wait(); });
    for (int i = 0; i < 5; ++i) pool.submit("greedy", [&] { order += 'g'; });
    pool.submit("modest", [&] { order += 'm'; });
    pool.submit("other", [&] { order += 'o'; });
    for (int i = 0; i < 5; ++i)
      pool.submit("last", [&, i] {
        if (i == 4) all.set_value();
      });
    go.set_value();
    all.get_future().wait();
  }
  EXPECT_EQ(order.substr(0, 3), "gmo");
  EXPECT_EQ(order.size(), 7U);
}

TEST(FairPool, OneOwnersWorkIsDoneInOrderAndNeverTwoAtATime) {
  std::atomic<int> running = 0, most = 0;
  std::vector<int> order;
  std::promise<void> done;
  {
    FairPool pool(3);
    for (int i = 0; i < 200; ++i)
      pool.submit("a", [&, i] {
        const int now = ++running;
        if (now > most) most = now;
        order.push_back(i);
        --running;
        if (i == 199) done.set_value();
      });
    done.get_future().wait();
  }
  EXPECT_EQ(most, 1);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(FairPool, WhatWaitsWhenItEndsIsDropped) {
  int ran = 0;
  {
    std::promise<void> begun, go;
    FairPool pool(1);
    pool.submit("a", [&] {
      begun.set_value();
      go.get_future().wait();
    });
    begun.get_future().wait();
    for (int i = 0; i < 100; ++i) pool.submit("a", [&] { ++ran; });
    std::thread later([&] { go.set_value(); });
    later.join();
  }
  EXPECT_LE(ran, 100);
}

}  // namespace
}  // namespace headframe
