#include "server/merge_worker/merge_schedule.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

using std::chrono::milliseconds;

class Schedule : public testing::Test {
 protected:
  using Refs = std::vector<KeyframeRef>;
  MergeSchedule schedule{{.travelled_m = 10, .junction_m = 5, .submap_s = 30}};
  MergeSchedule::Time now{};

  bool idle() const { return schedule.queued() + schedule.awaited() == 0; }
  /// Session 1 waits for these clouds.
  Refs wait_for(const Refs& wanted) {
    schedule.trigger(1, Trigger::goodbye, now);
    return schedule.wait_for(*schedule.next(), wanted, now);
  }
};

TEST_F(Schedule, TriggersOfOneSessionJoinAndOrderIsKept) {
  schedule.trigger(2, Trigger::link, now);
  schedule.trigger(1, Trigger::request, now);
  schedule.trigger(2, Trigger::goodbye, now + milliseconds(5));
  EXPECT_EQ(schedule.queued(), 2U);
  const auto first = schedule.next();
  EXPECT_EQ(first->session, 2);
  EXPECT_EQ(first->trigger, Trigger::link);
  EXPECT_EQ(first->triggered, now) << "time counts from the first trigger";
  EXPECT_EQ(schedule.next()->session, 1);
  EXPECT_FALSE(schedule.next());
  EXPECT_TRUE(idle());
}

TEST_F(Schedule, RobotsShareTheWorkersTime) {
  for (const SessionId id : {1, 2, 3, 4}) schedule.belongs(id, id < 4 ? "greedy" : "honest");
  for (const SessionId id : {1, 2, 3, 4}) schedule.trigger(id, Trigger::command, now);
  const auto session_that_takes = [&](double seconds) {
    const auto attempt = schedule.next();
    schedule.spent(attempt->session, seconds);
    return attempt->session;
  };
  EXPECT_EQ(session_that_takes(60), 1);
  EXPECT_EQ(session_that_takes(1), 4) << "behind one of the greedy robot's, not behind all";
  schedule.trigger(4, Trigger::travelled, now);
  EXPECT_EQ(session_that_takes(1), 4) << "it has used two seconds, the other sixty";
  EXPECT_EQ(session_that_takes(60), 2);
  schedule.belongs(5, "late");
  schedule.trigger(5, Trigger::link, now);
  EXPECT_EQ(session_that_takes(1), 5);
  EXPECT_EQ(session_that_takes(1), 3);
}

TEST_F(Schedule, WhoWasIdleHasSavedUpNothing) {
  schedule.belongs(1, "busy");
  for (const SessionId id : {2, 3, 4}) schedule.belongs(id, "idle");
  for (int i = 0; i < 5; ++i) {
    schedule.trigger(1, Trigger::command, now);
    schedule.spent(schedule.next()->session, 10);
  }
  schedule.trigger(1, Trigger::command, now);
  for (const SessionId id : {2, 3, 4}) schedule.trigger(id, Trigger::command, now);
  schedule.spent(schedule.next()->session, 11);
  EXPECT_EQ(schedule.next()->session, 1) << "it does not wait until the other has made up for its idle time";
}

TEST_F(Schedule, WhoAsksWhereItIsComesFirstAndKeepsNobodyWaiting) {
  for (const SessionId id : {1, 2, 3}) schedule.belongs(id, "robot" + std::to_string(id));
  schedule.spent(3, 1000);
  schedule.trigger(1, Trigger::command, now);
  schedule.trigger(2, Trigger::command, now);
  schedule.asks_where(3, true, now);
  EXPECT_EQ(schedule.next()->session, 3) << "however much it has used";
  schedule.asks_where(3, true, now);
  EXPECT_EQ(schedule.next()->session, 1) << "two of its tries do not follow each other";
  EXPECT_EQ(schedule.next()->session, 3);
  schedule.again({3, Trigger::localize, now});
  EXPECT_EQ(schedule.next()->session, 2);
  schedule.trigger(1, Trigger::command, now);
  EXPECT_EQ(schedule.next()->session, 1) << "what a try left over has no precedence";
  EXPECT_EQ(schedule.next()->session, 3);
  EXPECT_TRUE(idle());
}

TEST_F(Schedule, WhoAsksWhereItIsIsTriedAfterEachFewMetres) {
  const double asked_m = MergeSchedule::asked_m;
  schedule.asks_where(1, true, now);
  EXPECT_EQ(schedule.next()->trigger, Trigger::localize);
  schedule.travelled(1, asked_m - 0.1, now);
  EXPECT_TRUE(idle());
  schedule.travelled(1, 0.1, now);
  EXPECT_EQ(schedule.next()->trigger, Trigger::localize);
  schedule.asks_where(1, false, now);
  schedule.travelled(1, asked_m, now);
  EXPECT_TRUE(idle()) << "it asks no more";
}

TEST_F(Schedule, DistanceCountsSinceTheLastTry) {
  schedule.travelled(1, 9.9, now);
  EXPECT_TRUE(idle());
  schedule.travelled(1, 0.1, now);
  EXPECT_EQ(schedule.next()->trigger, Trigger::travelled);
  schedule.travelled(1, 9.9, now);
  EXPECT_TRUE(idle());
  schedule.trigger(1, Trigger::command, now);
  (void)schedule.next();
  schedule.travelled(1, 9.9, now);
  EXPECT_TRUE(idle()) << "any try counts";
}

TEST_F(Schedule, AJunctionAsksForATryButNotJustAfterTheLast) {
  schedule.travelled(1, 4.9, now);
  schedule.junction(1, now);
  EXPECT_TRUE(idle());
  schedule.travelled(2, 9.9, now);
  EXPECT_TRUE(idle()) << "another session's junction";
  schedule.travelled(1, 0.1, now);
  EXPECT_EQ(schedule.queued(), 1U);
  schedule.junction(1, now);
  EXPECT_EQ(schedule.queued(), 1U) << "the same junction, seen again";
  EXPECT_EQ(schedule.next()->trigger, Trigger::junction);
  schedule.travelled(1, 9.9, now);
  EXPECT_TRUE(idle()) << "the try was the junction's";
  schedule.junction(1, now);
  EXPECT_EQ(schedule.next()->trigger, Trigger::junction) << "far enough: at once";
}

TEST_F(Schedule, ASessionComesToRestWhenNoKeyframeFollows) {
  using Ids = std::vector<SessionId>;
  schedule.grows(1, now);
  schedule.grows(1, now + milliseconds(1000));
  EXPECT_EQ(schedule.next_deadline(), now + milliseconds(121000));
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(120999)), Ids());
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(121000)), Ids{1});
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(500000)), Ids()) << "once";
  schedule.asks(1, now + milliseconds(500000));
  EXPECT_FALSE(schedule.next_deadline()) << "it rests already";
}

TEST_F(Schedule, ARobotThatAsksAndStandsStillHasNotToWaitAsLong) {
  using Ids = std::vector<SessionId>;
  schedule.grows(1, now);
  schedule.asks(1, now);
  schedule.grows(1, now + milliseconds(1000));
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(4000)), Ids()) << "it drove on";
  schedule.asks(1, now + milliseconds(5000));
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(7999)), Ids());
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(8000)), Ids{1});
  schedule.grows(2, now);
  schedule.asks(2, now + milliseconds(119000));
  EXPECT_EQ(schedule.next_deadline(), now + milliseconds(120000)) << "asking makes nothing later";
  schedule.ended(2);
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(200000)), Ids()) << "it said goodbye";
}

TEST_F(Schedule, OthersWaitForARobotsSessionsTenMinutesAnHour) {
  using Ids = std::vector<SessionId>;
  const auto minute = [this](double m) { return now + milliseconds(static_cast<int>(m * 60000)); };
  for (const SessionId session : {1, 2, 3}) schedule.belongs(session, "slow");
  schedule.belongs(4, "other");
  schedule.grows(1, now);
  schedule.grows(4, minute(6));
  EXPECT_EQ(schedule.waited_out(minute(9.99)), Ids());
  schedule.grows(1, minute(9.99));
  schedule.grows(2, minute(9.99));
  EXPECT_EQ(schedule.next_deadline(), minute(8)) << "4 would rest";
  EXPECT_EQ(schedule.waited_out(minute(10)), (Ids{1, 2})) << "that it grows on is no reason to wait on";
  schedule.grows(1, minute(11));
  EXPECT_EQ(schedule.waited_out(minute(15)), Ids()) << "once";
  EXPECT_EQ(schedule.waited_out(minute(16)), Ids{4}) << "each robot has its own time";
  schedule.grows(3, minute(59.9));
  EXPECT_EQ(schedule.waited_out(minute(59.9)), Ids{3}) << "a new session is no new time";
  schedule.ended(3);
  schedule.grows(3, minute(60));
  EXPECT_EQ(schedule.waited_out(minute(69.9)), Ids()) << "a new hour is";
  EXPECT_EQ(schedule.waited_out(minute(70)), Ids{3});
}

TEST_F(Schedule, NobodyWaitsForWhatHasEndedOrRests) {
  schedule.grows(1, now);
  schedule.grows(2, now);
  schedule.ended(1);
  EXPECT_EQ(schedule.come_to_rest(now + milliseconds(120000)), std::vector<SessionId>{2});
  EXPECT_FALSE(schedule.next_deadline());
  EXPECT_EQ(schedule.waited_out(now + milliseconds(700000)), std::vector<SessionId>());
}

TEST_F(Schedule, CloudsAreAskedForOnceAndTheAttemptComesBackWhenAllAreHere) {
  EXPECT_EQ(wait_for({{2, 7}, {3, 1}}), (Refs{{2, 7}, {3, 1}}));
  EXPECT_EQ(wait_for({{2, 7}, {2, 8}}), (Refs{{2, 8}})) << "7 is on its way";
  EXPECT_EQ(schedule.awaited(), 3U);
  schedule.cloud_came({2, 7}, now);
  schedule.cloud_came({3, 1}, now);
  EXPECT_EQ(schedule.queued(), 0U);
  schedule.cloud_came({2, 8}, now);
  EXPECT_EQ(schedule.awaited(), 0U);
  const auto attempt = schedule.next();
  ASSERT_TRUE(attempt);
  EXPECT_EQ(attempt->trigger, Trigger::goodbye);
  EXPECT_EQ(attempt->round, 1);
  EXPECT_TRUE(idle());
}

TEST_F(Schedule, CloudsThatWillNotComeAreNotAwaitedUntilTheRobotIsBack) {
  wait_for({{2, 7}, {2, 8}});
  schedule.cloud_will_not_come({2, 7});
  EXPECT_EQ(schedule.queued(), 0U);
  schedule.robot_left(2);
  EXPECT_EQ(schedule.queued(), 1U);
  EXPECT_TRUE(schedule.in_vain({2, 7}));
  EXPECT_TRUE(schedule.in_vain({2, 8}));
  schedule.robot_came(2);
  EXPECT_FALSE(schedule.in_vain({2, 7}));
  schedule.robot_left(3);
  EXPECT_EQ(schedule.queued(), 1U) << "nothing was asked of it";
}

TEST_F(Schedule, ARobotThatStillSendsIsWaitedFor) {
  wait_for({{2, 7}, {2, 8}});
  EXPECT_EQ(schedule.next_deadline(), now + milliseconds(30000));
  schedule.cloud_came({2, 7}, now + milliseconds(20000));
  schedule.tick(now + milliseconds(49999));
  EXPECT_EQ(schedule.awaited(), 1U);
  schedule.tick(now + milliseconds(50000));
  EXPECT_EQ(schedule.awaited(), 0U);
  EXPECT_EQ(schedule.queued(), 1U);
  EXPECT_TRUE(schedule.in_vain({2, 8}));
  EXPECT_FALSE(schedule.next_deadline());
  schedule.cloud_came({2, 8}, now);
  EXPECT_FALSE(schedule.in_vain({2, 8})) << "late is better than never";
}

TEST_F(Schedule, WantingWhatCameInVainComesBackAtOnceButNotForEver) {
  wait_for({{2, 7}});
  schedule.cloud_will_not_come({2, 7});
  int rounds = 0;
  while (const auto attempt = schedule.next()) {
    EXPECT_TRUE(schedule.wait_for(*attempt, {{2, 7}}, now).empty());
    ASSERT_LE(++rounds, MergeSchedule::most_rounds);
  }
  EXPECT_EQ(rounds, MergeSchedule::most_rounds);
  EXPECT_TRUE(idle());
}

TEST_F(Schedule, UnfinishedGoesBehindOthers) {
  schedule.trigger(1, Trigger::command, now);
  schedule.trigger(2, Trigger::command, now);
  schedule.again(*schedule.next());
  EXPECT_EQ(schedule.next()->session, 2);
  EXPECT_EQ(schedule.next()->session, 1);
}

}  // namespace
}  // namespace headframe
