// A session whose odometry jumped goes on as another one, and its robot as if nothing were.
#include <future>
#include <numeric>
#include <random>

#include "tests/support/split_sessions.hpp"

namespace headframe {
namespace {

TEST_F(HubParts, WhatFollowsAJumpIsASessionOfItsOwnAndTheRobotGoesOn) {
  keyframes(1, 7);
  for (const std::uint64_t i : {2, 5}) cloud(i);
  cut(1, 4);
  EXPECT_EQ(stored(1), (Numbers{1, 2, 3}));
  EXPECT_EQ(stored(2), (Numbers{4, 5, 6, 7}));
  EXPECT_EQ(store_->cloud({1, 2}).value(), "cloud 2");
  EXPECT_EQ(store_->cloud({2, 2}).value(), "cloud 5");
  EXPECT_FALSE(store_->cloud({1, 5}));
  for (const char* told : {"added 2", "came 2", "ended 1", "keyframe 2/4", "cloud 2/2"})
    EXPECT_TRUE(news_.has(told)) << told;
  keyframes(8, 8);
  for (const std::uint64_t i : {3, 8}) cloud(i);
  EXPECT_EQ(stored(1), (Numbers{1, 2, 3}));
  EXPECT_EQ(stored(2), (Numbers{4, 5, 6, 7, 8}));
  EXPECT_EQ(store_->cloud({1, 3}).value(), "cloud 3") << "of the time before the jump";
  EXPECT_EQ(store_->cloud({2, 5}).value(), "cloud 8");
  EXPECT_EQ(link_->keyframes, (Numbers{1, 2, 3, 4, 5, 6, 7, 8})) << "acknowledged by its own numbers";
  EXPECT_EQ(link_->clouds, (Numbers{2, 5, 3, 8}));
  EXPECT_TRUE(link_->stored);
  EXPECT_EQ(hub_->keys().at(2).session, "s1~4");
  EXPECT_FALSE(row(1).connected);
  EXPECT_TRUE(row(1).complete);
  EXPECT_TRUE(row(2).connected);
  EXPECT_EQ(row(1).why_cut,
            "from keyframe 4 on it is session s1~4, which is merged for itself: its odometry jumps 400 m");
  EXPECT_EQ(row(2).why_cut, "");
  EXPECT_EQ(hub_->policy_of(id_).cut, row(1).why_cut) << "the robot is told";
  for (const bool restarted : {false, true}) {
    restarted ? start() : come();
    EXPECT_EQ(id_, 1);
    EXPECT_EQ(durable_.keyframes, 8U) << restarted;
    EXPECT_EQ(durable_.clouds, (Numbers{2, 3, 5, 8}));
    EXPECT_EQ(hub_->durable_keyframes(id_), 8U);
  }
  EXPECT_NE(hub_->policy_of(id_).cut.find("from keyframe 4 on it is session s1~4"), std::string::npos);
  keyframes(7, 9);  // what it was not sure of is repeated
  EXPECT_EQ(stored(2), (Numbers{4, 5, 6, 7, 8, 9}));
  EXPECT_TRUE(link_->stored);
}

TEST_F(HubParts, EachFurtherJumpBeginsAnotherPartUpToABound) {
  keyframes(1, 5);
  cut(1, 3);
  keyframes(6, 8);
  cut(2, 4);  // the robot's sixth
  EXPECT_EQ(hub_->keys().at(3).session, "s1~6");
  EXPECT_EQ(stored(2), (Numbers{3, 4, 5}));
  EXPECT_EQ(stored(3), (Numbers{6, 7, 8}));
  start();
  EXPECT_EQ(durable_.keyframes, 8U);
  cut(2, 4);
  EXPECT_EQ(hub_->keys().size(), 3U) << "said again of what was split before";
  for (std::uint64_t next = 9; next < 30; next += 2) {
    keyframes(next, next + 1);
    cut(static_cast<SessionId>(hub_->keys().rbegin()->first), 3 - (next == 9 ? 0 : 1));
  }
  EXPECT_EQ(hub_->keys().size(), 1 + SessionHub::most_parts);
  EXPECT_TRUE(link_->stored);
  EXPECT_NE(hub_->policy_of(id_).cut.find("is left out of merging"), std::string::npos);
  EXPECT_NE(hub_->policy_of(id_).cut.find("begin a new session"), std::string::npos);
  start();
  EXPECT_EQ(durable_.keyframes, 30U);
}

TEST_F(HubParts, WhatARobotBeginsIsOfItsSiteAsItWasThenAndItsPartsAreToo) {
  const auto set_site = [&](const std::string& robot, const std::string& site) {
    std::promise<Result<void>> told;
    hub_->set_robot_site(robot, site, [&](const Result<void>& done) { told.set_value(done); });
    return told.get_future().get();
  };
  const std::string robot = hello().session.robot;
  EXPECT_EQ(set_site(robot, "a/b").error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(set_site("", "north").error().code, ErrorCode::invalid_argument);
  ASSERT_TRUE(set_site(robot, "north"));
  EXPECT_EQ(row(1).site, "") << "it began before";
  start();
  EXPECT_EQ(hub_->robot_sites(), (std::map<std::string, std::string>{{robot, "north"}})) << "after a restart, too";
  Hello next = hello(20);
  next.session.session = "s2";
  next.spool_id += 1;
  link_ = std::make_shared<RobotEnd>();
  id_ = hub_->admit(next, link_).value().session;
  settle();
  EXPECT_EQ(row(2).site, "north");
  EXPECT_TRUE(news_.has("added at north 2"));
  ASSERT_TRUE(set_site(robot, ""));
  keyframes(1, 7);
  cut(2, 4);
  EXPECT_EQ(row(3).site, "north");
  EXPECT_TRUE(news_.has("added at north 3"));
  start();
  EXPECT_EQ(row(3).site, "north");
  EXPECT_TRUE(hub_->robot_sites().empty());
}

TEST_F(HubParts, PartsCountAmongTheSessionsThatARobotMayBegin) {
  RobotLimits limits;
  limits.sessions_a_day = 2;
  hub_ = std::make_unique<SessionHub>(*store_, news_, limits);
  come();
  keyframes(1, 5);
  cut(1, 3);
  keyframes(6, 8);
  cut(2, 4);
  EXPECT_EQ(hub_->keys().size(), 2U);
  EXPECT_NE(hub_->policy_of(id_).cut.find("from keyframe 6 on it is left out of merging"), std::string::npos);
}

TEST_F(HubParts, ACloudThatWasOnItsWayWhenItsKeyframeMovedComesAgain) {
  keyframes(1, 7);
  interrupted_->before_cloud = [this] { hub_->tell_cut(1, {4, true, "its odometry jumps 400 m"}); };
  cloud(5);
  EXPECT_FALSE(link_->stored) << "its connection ends";
  EXPECT_EQ(link_->refused, Numbers{}) << "it would never be sent again";
  come();
  cloud(5);
  EXPECT_TRUE(link_->stored);
  EXPECT_EQ(store_->cloud({2, 2}).value(), "cloud 5");
}

/// Whatever the robot sends, wherever its odometry jumps, and whenever the link or the server goes away.
TEST_F(HubParts, EachKeyframeAndCloudIsStoredOnceInOrderWhateverHappens) {
  std::mt19937 random(5);
  const auto below = [&](std::uint64_t n) { return random() % n; };
  std::uint64_t sent = 0;
  std::set<std::uint64_t> clouds;
  for (int step = 0; step < 120; ++step) {
    const std::uint64_t choice = below(10), last = static_cast<std::uint64_t>(hub_->keys().rbegin()->first);
    if (choice < 4) {
      const std::uint64_t more = 1 + below(5), again = below(std::min<std::uint64_t>(sent, 3) + 1);
      keyframes(sent + 1 - again, sent + more);
      sent += more;
    } else if (choice < 7 && sent > 0) {
      const std::uint64_t of = 1 + below(sent);
      cloud(of);
      clouds.insert(of);
    } else if (choice == 7 && row(static_cast<SessionId>(last)).keyframes > 1) {
      cut(static_cast<SessionId>(last), 2 + below(row(static_cast<SessionId>(last)).keyframes - 1));
    } else if (choice > 7) {
      choice == 8 ? come() : start();
      EXPECT_EQ(durable_.keyframes, sent);
      EXPECT_EQ(durable_.clouds, Numbers(clouds.begin(), clouds.end()));
    }
    ASSERT_TRUE(link_->stored) << step;
  }
  EXPECT_EQ(hub_->keys().size(), 1 + SessionHub::most_parts);
  Numbers all;
  std::set<std::uint64_t> found;
  for (const auto& [id, key] : hub_->keys()) {
    const Numbers part = stored(id);
    const Numbers stored_clouds = store_->cloud_sequences(id).value();
    for (const std::uint64_t sequence : stored_clouds) {
      EXPECT_EQ(store_->cloud({id, sequence}).value(), "cloud " + std::to_string(all.size() + sequence));
      found.insert(all.size() + sequence);
    }
    all.insert(all.end(), part.begin(), part.end());
  }
  Numbers expected(sent);
  std::iota(expected.begin(), expected.end(), 1);
  EXPECT_EQ(all, expected);
  EXPECT_EQ(found, clouds);
}

}  // namespace
}  // namespace headframe
