#include "client/uplink/server_list.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

ServerList list_of(std::size_t servers) {
  std::vector<Endpoint> all;
  for (std::size_t i = 0; i < servers; ++i) all.push_back({"base" + std::to_string(i), 7447});
  return {all, Backoff(0.5, 4, 1)};
}

/// Attempts one after the other that all fail, until one is followed by a pause: who was tried.
std::vector<std::size_t> until_a_pause(ServerList& list, double& pause_s) {
  std::vector<std::size_t> tried;
  do {
    tried.push_back(list.take());
    pause_s = list.failed(tried.back());
  } while (pause_s == 0);
  return tried;
}

TEST(ServerList, OneServerAloneIsTriedAgainAfterEachPause) {
  ServerList list = list_of(1);
  double pause_s = 0;
  EXPECT_EQ(until_a_pause(list, pause_s), std::vector<std::size_t>{0});
  EXPECT_LE(pause_s, 0.5);
  EXPECT_EQ(until_a_pause(list, pause_s), std::vector<std::size_t>{0});
  EXPECT_GE(pause_s, 0.5) << "the span has doubled";
}

TEST(ServerList, AfterAFailureTheNextIsTriedAtOnceAndThePauseComesWhenAllHaveFailed) {
  ServerList list = list_of(3);
  double pause_s = 0;
  EXPECT_EQ(until_a_pause(list, pause_s), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_GE(pause_s, 0.25);
  EXPECT_EQ(until_a_pause(list, pause_s), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_GE(pause_s, 0.5);
}

TEST(ServerList, ALostLinkIsFollowedByTheNextServerAtOnce) {
  ServerList list = list_of(2);
  const std::size_t first = list.take();
  list.found(first);
  EXPECT_EQ(list.failed(first), 0);
  EXPECT_EQ(list.take(), 1U);
  EXPECT_GT(list.failed(1), 0) << "nobody is there: no reason to hurry";
  EXPECT_EQ(list.take(), 0U);
}

TEST(ServerList, BesideASilentLinkItsOwnServerIsAskedFirstAndThenTheOthersInTurn) {
  ServerList list = list_of(2);
  EXPECT_EQ(list.take(), 0U);
  EXPECT_EQ(list.take(), 1U) << "beside the first, which is slow";
  list.found(1);
  EXPECT_EQ(list.take(), 1U);
  EXPECT_EQ(list.take(), 0U);
  EXPECT_EQ(list.take(), 1U);
}

TEST(ServerList, WhoIsFoundEndsTheLongPauses) {
  ServerList list = list_of(2);
  double pause_s = 0;
  for (int i = 0; i < 6; ++i) (void)until_a_pause(list, pause_s);
  EXPECT_GE(pause_s, 2) << "of at most four seconds";
  list.found(list.take());
  (void)list.failed(0);
  EXPECT_LE(until_a_pause(list, pause_s).size(), 2U);
  EXPECT_LE(pause_s, 0.5);
}

}  // namespace
}  // namespace headframe
