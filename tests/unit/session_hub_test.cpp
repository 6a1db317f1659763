// Which of a robot's connections the hub speaks to.
#include "server/net/session_hub.hpp"

#include "common/wire/capabilities.hpp"
#include "common/wire/limits.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/nobodys_news.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

/// What a connection was told, in words.
class HeardLink : public RobotLink {
 public:
  std::vector<std::string> heard;
  void settled(std::size_t, const Result<void>& result) override {
    if (!result) heard.push_back("not stored");
  }
  void keyframes_durable(std::uint64_t) override {}
  void poses_durable(std::uint64_t) override {}
  void cloud_durable(std::uint64_t) override {}
  void cloud_refused(std::uint64_t, const std::string&) override {}
  void request_submap(const std::vector<std::uint64_t>&) override { heard.push_back("request"); }
  void update_transform(std::shared_ptr<const TransformPages> all) override {
    heard.push_back("transform");
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(all->front()));
    update = message.transform_update();
    pages = *all;
  }
  v1::TransformUpdate update;  // the last; its first page
  TransformPages pages;
  void tell_localization(std::shared_ptr<const std::string> payload) override {
    heard.push_back("localization");
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(*payload));
    localization = message.localization();
  }
  v1::Localization localization;  // the last
  void tell_surroundings(SurroundingsKind, std::shared_ptr<const std::string>) override {}
  void stand_by() override { heard.push_back("stand by"); }
  void close(v1::ErrorKind, const std::string&, bool permanent) override {
    heard.push_back(permanent ? "closed for good" : "closed");
  }
};

class News : public NobodysNews {
 public:
  std::vector<std::string> heard;
  void robot_came(SessionId, bool answers) override { heard.push_back(answers ? "came" : "came and gives no clouds"); }
  void robot_left(SessionId) override { heard.push_back("left"); }
  void asks_where(SessionId, bool asks) override { heard.push_back(asks ? "asks where" : "asks no more"); }
};

using Words = std::vector<std::string>;

Hello asks_for_provisional(Hello hello) {
  hello.capabilities = robot_capabilities(true);
  return hello;
}

class Hub : public testing::Test {
 protected:
  static Hello hello(bool spare) {
    Hello h = robot_hello();
    h.spool_runs = {10};
    h.spare = spare;
    return h;
  }
  void SetUp() override {
    id_ = hub_.admit(hello(false), first_).value().session;
    const SessionId other = hub_.admit(robot_hello("bee"), std::make_shared<HeardLink>()).value().session;
    ASSERT_EQ(hub_.admit(hello(true), spare_).value().session, id_);
    atlas_.components.push_back({id_, {{id_, Pose::Identity()}, {other, Pose::Identity()}}});
  }
  void TearDown() override { store_.reset(); }  // its callbacks find the hub

  TempDir dir_;
  std::unique_ptr<Store> store_ = open(dir_);
  News news_;
  SessionHub hub_{*store_, news_};
  std::shared_ptr<HeardLink> first_ = std::make_shared<HeardLink>(), spare_ = std::make_shared<HeardLink>();
  SessionId id_ = 0;
  Atlas atlas_;
};

TEST_F(Hub, WhatIsProvisionalIsToldToThoseWhoAskAlone) {
  const auto asks = std::make_shared<HeardLink>(), plain = std::make_shared<HeardLink>();
  const SessionId cat = hub_.admit(asks_for_provisional(robot_hello("cat")), asks).value().session;
  const SessionId dog = hub_.admit(robot_hello("dog"), plain).value().session;
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  atlas_.components = {{cat, {{cat, Pose::Identity()}}, {{dog, T, 0.97, 25}}},
                       {dog, {{dog, Pose::Identity()}}, {{cat, T.inverse(), 0.97, 25}}}};
  hub_.tell_provisional(atlas_, atlas_.components);
  EXPECT_EQ(plain->heard, Words{});
  ASSERT_EQ(asks->heard, Words{"transform"});
  ASSERT_EQ(asks->update.provisional_size(), 1);
  EXPECT_EQ(asks->update.provisional(0).session().robot(), "dog");
  EXPECT_EQ(asks->update.provisional(0).awaited_m(), 25);
  EXPECT_TRUE(from_proto(asks->update.provisional(0).t_component_session())->isApprox(T, 1e-9));

  const auto comes_back = [&](const Hello& hello) {
    return hub_.admit(hello, std::make_shared<HeardLink>()).value().transform;
  };
  EXPECT_NE(comes_back(asks_for_provisional(robot_hello("cat"))), nullptr);
  EXPECT_EQ(comes_back(robot_hello("dog")), nullptr) << "nothing was merged";
}

TEST_F(Hub, HowSureATransformIsIsToldToThoseWhoListIt) {
  const auto asks = std::make_shared<HeardLink>(), plain = std::make_shared<HeardLink>();
  const SessionId cat = hub_.admit(asks_for_provisional(robot_hello("cat")), asks).value().session;
  const SessionId dog = hub_.admit(robot_hello("dog"), plain).value().session;
  atlas_.components = {{cat, {{cat, Pose::Identity()}, {dog, pose_from_yaw(0.5, {1, 2, 3})}}}};
  atlas_.components[0].supports = {{.session = cat, .merges = 1},
                                   {.session = dog,
                                    .merged_with = cat,
                                    .probability = 0.97,
                                    .merges = 1,
                                    .shared_m = 35,
                                    .confirmed = true,
                                    .deviation_m = 0.1,
                                    .deviation_rad = 0.005}};
  hub_.publish(atlas_, atlas_.components, {});
  ASSERT_EQ(asks->update.sessions_size(), 2);
  EXPECT_FALSE(asks->update.sessions(0).support().has_merged_with()) << "the anchor";
  const auto& support = asks->update.sessions(1).support();
  EXPECT_EQ(support.merged_with().robot(), "cat");
  EXPECT_EQ(support.probability(), 0.97);
  EXPECT_EQ(support.shared_m(), 35);
  EXPECT_TRUE(support.confirmed());
  EXPECT_EQ(support.deviation_m(), 0.1F);
  ASSERT_EQ(plain->update.sessions_size(), 2);
  EXPECT_FALSE(plain->update.sessions(1).has_support());
}

TEST_F(Hub, ARobotsStateIsKeptWithItsAgeAndASparesIsNot) {
  const auto row = [&] {
    for (const SessionRow& r : hub_.sessions())
      if (r.id == id_) return r;
    throw std::out_of_range("no row");
  };
  EXPECT_FALSE(row().live);
  hub_.take(id_, LiveReceived{{5, std::nullopt, 0.5, "hot"}, 4}, first_);
  hub_.take(id_, LiveReceived{{6, std::nullopt, 0.1, "a spare"}, 9}, spare_);
  EXPECT_EQ(row().live->state.health, "hot");
  EXPECT_EQ(row().live->news, 1U);
  EXPECT_EQ(row().backlog, 4U);
  EXPECT_GE(row().live->age_s, 0);
  hub_.take(id_, LiveReceived{{7, std::nullopt, 0.5, "hot"}, 0}, first_);
  EXPECT_EQ(row().live->news, 2U);
  hub_.left(id_, first_.get());
  EXPECT_EQ(row().live->state.stamp_s, 7) << "where it was seen last";
}

TEST_F(Hub, WhoLosesATransformHearsWhyAlsoWhenItComesBack) {
  const SessionId other = atlas_.components[0].placements[1].session;
  hub_.publish(atlas_, atlas_.components, {});
  EXPECT_EQ(first_->update.withdrawn_size(), 0);
  atlas_.revision = 9;
  atlas_.components = {{id_, {{id_, Pose::Identity()}}}, {other, {{other, Pose::Identity()}}}};
  hub_.publish(atlas_, atlas_.components, {{id_, other, "other sessions contradict it"}});
  ASSERT_EQ(first_->update.withdrawn_size(), 1);
  EXPECT_EQ(first_->update.withdrawn(0).revision(), 9U);
  EXPECT_EQ(first_->update.withdrawn(0).reason(), "other sessions contradict it");
  EXPECT_EQ(first_->update.withdrawn(0).b().robot(), "bee");
  const auto again = hub_.admit(hello(false), std::make_shared<HeardLink>());
  ASSERT_NE(again->transform, nullptr);
  v1::ServerMessage message;
  ASSERT_TRUE(message.ParseFromString(again->transform->front()));
  EXPECT_EQ(message.transform_update().withdrawn_size(), 1);
  for (int i = 0; i < 40; ++i) hub_.publish(atlas_, atlas_.components, {{id_, other, "again"}});
  EXPECT_LE(first_->update.withdrawn_size(), 16) << "an update stays small";
}

TEST_F(Hub, FiveThousandSessionsReachARobotThatTakesPagesAndOthersHearOfThemselves) {
  const auto takes_pages = std::make_shared<HeardLink>(), old = std::make_shared<HeardLink>();
  const SessionId cat = hub_.admit(asks_for_provisional(robot_hello("cat")), takes_pages).value().session;
  const SessionId dog = hub_.admit(robot_hello("dog"), old).value().session;
  Component all{cat, {{cat, Pose::Identity()}, {dog, pose_from_yaw(0.5, {1, 2, 3})}}};
  for (int i = 0; i < 4998; ++i) {
    const auto gone = std::make_shared<HeardLink>();
    const SessionId id =
        hub_.admit(robot_hello("a robot of a long name, number " + std::to_string(i)), gone).value().session;
    all.placements.push_back({id, pose_from_yaw(0, {1.0 * i, 0, 0})});
  }
  atlas_.components = {all};
  hub_.publish(atlas_, atlas_.components, {});
  int told = 0;
  for (const std::string& page : takes_pages->pages) {
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(page));
    EXPECT_LE(page.size(), limits::frame_bytes);
    told += message.transform_update().sessions_size();
  }
  EXPECT_EQ(told, 5000);
  ASSERT_EQ(old->pages.size(), 1U);
  ASSERT_EQ(old->update.sessions_size(), 2);
  EXPECT_EQ(old->update.sessions(1).session().robot(), "dog");
  EXPECT_EQ(old->update.anchor().robot(), "cat");
}

TEST_F(Hub, OneQuestionOfASessionStandsAtATime) {
  news_.heard.clear();
  const auto ask = [&](bool asks, const std::shared_ptr<HeardLink>& link) {
    hub_.take(id_, WhereAsked{asks}, link);
    while (hub_.unsettled() > 0) std::this_thread::yield();
  };
  ask(true, first_);
  ask(true, first_);
  EXPECT_EQ(news_.heard, Words{"asks where"});
  ask(true, spare_);
  ask(false, spare_);
  EXPECT_EQ(news_.heard, Words{"asks where"}) << "a spare asks nothing";
  ask(false, first_);
  ask(true, first_);
  EXPECT_EQ(news_.heard, (Words{"asks where", "asks no more", "asks where"}));
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(news_.heard.back(), "asks where") << "who takes over asks on";
}

TEST_F(Hub, WhoAskedIsAnsweredAndNobodyElse) {
  SessionLocalization found{.found = true, .component = id_, .on = id_, .keyframe = 4};
  found.T_component_session = pose_from_yaw(0.5, {1, 2, 3});
  found.covariance.setIdentity();
  hub_.tell_localization(id_, found);
  EXPECT_EQ(first_->heard, Words{}) << "it did not ask";
  hub_.take(id_, WhereAsked{true}, first_);
  while (hub_.unsettled() > 0) std::this_thread::yield();
  hub_.tell_localization(id_, found);
  ASSERT_EQ(first_->heard.back(), "localization");
  EXPECT_EQ(spare_->heard, Words{});
  EXPECT_TRUE(first_->localization.found());
  EXPECT_EQ(first_->localization.anchor().robot(), "ant");
  EXPECT_EQ(first_->localization.keyframe(), 4U);
  EXPECT_EQ(first_->localization.covariance_size(), 36);
  EXPECT_TRUE(from_proto(first_->localization.t_component_session())->isApprox(found.T_component_session, 1e-9));
  const auto again = std::make_shared<HeardLink>();
  ASSERT_TRUE(hub_.admit(hello(false), again));
  hub_.tell_localization(id_, found);
  EXPECT_EQ(again->heard, Words{}) << "a new connection asks anew";
}

TEST_F(Hub, TheSpareHearsNothingUntilItTakesOverAndThenAllThatCounts) {
  hub_.publish(atlas_, atlas_.components, {});
  hub_.request_submap(id_, {1});
  EXPECT_EQ(first_->heard, (Words{"transform", "request"}));
  EXPECT_EQ(spare_->heard, Words{});
  news_.heard.clear();
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(spare_->heard, Words{"transform"});
  EXPECT_EQ(news_.heard, (Words{"left", "came"})) << "what was asked of the first has to be asked again";
  hub_.request_submap(id_, {1});
  EXPECT_EQ(spare_->heard, (Words{"transform", "request"}));
  EXPECT_EQ(first_->heard, (Words{"transform", "request", "stand by"}));
  hub_.take(id_, TakenOver{}, first_);
  hub_.request_submap(id_, {1});
  EXPECT_EQ(first_->heard, (Words{"transform", "request", "stand by", "transform", "request"}));
}

TEST_F(Hub, ASpareThatLeavesIsNoLossAndTheFirstOneIs) {
  news_.heard.clear();
  hub_.left(id_, spare_.get());
  EXPECT_EQ(news_.heard, Words{});
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(news_.heard, Words{}) << "it is not there any more";
  hub_.left(id_, first_.get());
  EXPECT_EQ(news_.heard, Words{"left"});
}

TEST_F(Hub, ASpareCarriesWhatNobodyElseCarries) {
  hub_.publish(atlas_, atlas_.components, {});
  hub_.left(id_, first_.get());
  const auto late = std::make_shared<HeardLink>();
  EXPECT_TRUE(hub_.admit(hello(true), late).value().transform);
  hub_.request_submap(id_, {1});
  EXPECT_EQ(late->heard, Words{"request"});
  hub_.take(id_, TakenOver{}, late);
  EXPECT_EQ(late->heard, (Words{"request", "transform"})) << "it did not listen before";
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(late->heard.back(), "stand by");
}

TEST_F(Hub, ARobotThatIsRevokedLosesItsSparesToo) {
  hub_.end_robot("ant", "revoked");
  EXPECT_EQ(first_->heard, Words{"closed for good"});
  EXPECT_EQ(spare_->heard, Words{"closed for good"});
}

TEST_F(Hub, ANewConnectionOfTheSameRunLeavesItsSparesAndOfAnotherDoesNot) {
  const auto second = std::make_shared<HeardLink>(), third = std::make_shared<HeardLink>();
  ASSERT_TRUE(hub_.admit(hello(false), second));
  EXPECT_EQ(first_->heard, Words{"closed"});
  EXPECT_EQ(spare_->heard, Words{});
  Hello anew = hello(false);
  anew.spool_runs = {10, 11};
  ASSERT_TRUE(hub_.admit(anew, third));
  EXPECT_EQ(second->heard, Words{"closed"});
  EXPECT_EQ(spare_->heard, Words{"closed"});
}

TEST(Quota, OneRobotLocksOutItselfAndNobodyElse) {
  const TempDir dir;
  auto store = open(dir);
  News news;
  RobotLimits limits;
  limits.robots = 20;
  limits.sessions = 3;
  limits.sessions_a_day = 5;
  SessionHub hub{*store, news, limits};
  std::vector<std::shared_ptr<HeardLink>> links;
  const auto admit = [&](const std::string& robot, int session) {
    Hello hello = robot_hello(robot);
    hello.session.session = std::to_string(session);
    links.push_back(std::make_shared<HeardLink>());
    return hub.admit(hello, links.back());
  };
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(admit("greedy", i));
  const auto fourth = admit("greedy", 3);
  ASSERT_FALSE(fourth);
  EXPECT_EQ(fourth.error().code, ErrorCode::unavailable);
  EXPECT_NE(fourth.error().message.find("limits.sessions "), std::string::npos) << fourth.error().message;
  EXPECT_TRUE(admit("greedy", 0)) << "one that it has may come again";
  EXPECT_TRUE(admit("honest", 0));
  links.erase(links.begin(), links.begin() + 4);  // it leaves, but for the one that came again
  for (int i = 3; i < 5; ++i) EXPECT_TRUE(admit("greedy", i));
  links.clear();
  const auto sixth = admit("greedy", 5);
  ASSERT_FALSE(sixth);
  EXPECT_NE(sixth.error().message.find("limits.sessions_a_day"), std::string::npos) << sixth.error().message;
  EXPECT_TRUE(admit("greedy", 4)) << "one that it began";
  EXPECT_TRUE(admit("honest", 1));
  store.reset();
}

TEST(Quota, WhatARobotMaySendInADayComesBackOverTheDay) {
  RobotLimits limits;
  limits.keyframes_a_day = 24;
  limits.stored_mib_a_day = 1;
  RobotQuota quota(limits);
  const RobotQuota::Time start{};
  const auto hours = [&](int n) { return start + std::chrono::hours(n); };
  for (int i = 0; i < 24; ++i) EXPECT_EQ(quota.stores("ant", 1, 1000, start), "");
  EXPECT_NE(quota.stores("ant", 1, 1000, start).find("limits.keyframes_a_day"), std::string::npos);
  EXPECT_NE(quota.objection("ant", 0, false, start).find("limits.keyframes_a_day"), std::string::npos);
  EXPECT_EQ(quota.objection("bee", 0, false, start), "") << "another robot's";
  EXPECT_EQ(quota.stores("ant", 1, 1000, hours(1)), "") << "an hour gives one";
  EXPECT_NE(quota.stores("ant", 1, 1000, hours(1)), "");
  EXPECT_EQ(quota.objection("ant", 0, false, hours(100)), "");
  for (int i = 0; i < 24; ++i) EXPECT_EQ(quota.stores("ant", 1, 0, hours(100)), "");
  EXPECT_NE(quota.stores("ant", 1, 0, hours(100)), "") << "idle days save up nothing";

  EXPECT_EQ(quota.stores("bee", 0, 1 << 20, start), "") << "as much as a day allows";
  EXPECT_NE(quota.stores("bee", 0, 1, start).find("limits.stored_mib_a_day"), std::string::npos);
}

TEST(Quota, ARobotOverItsQuotaIsToldSoAndNothingOfItIsStored) {
  RobotLimits limits;
  limits.keyframes_a_day = 1;
  const TempDir dir;
  auto store = open(dir);
  News news;
  SessionHub hub{*store, news, limits};
  const auto link = std::make_shared<HeardLink>();
  const auto admitted = hub.admit(robot_hello("ant"), link);
  ASSERT_TRUE(admitted);
  const auto send = [&](std::uint64_t sequence) {
    hub.take(admitted->session, KeyframeReceived{line_keyframe(sequence), 0}, link);
  };
  send(1);
  send(2);
  store.reset();  // writes what was taken
  EXPECT_EQ(hub.durable_keyframes(admitted->session), 1U);
  ASSERT_EQ(std::count(link->heard.begin(), link->heard.end(), "not stored"), 1) << "the second";
}

}  // namespace
}  // namespace headframe
