// What the robot, the worker and others are told of a session that goes on as another one.
#include "common/wire/limits.hpp"
#include "tests/support/split_sessions.hpp"

namespace headframe {
namespace {

TEST_F(HubParts, CloudsOfEachPartAreAskedOfTheRobotByItsNumbers) {
  keyframes(1, 7);
  cut(1, 4);
  hub_->request_submap(1, {1, 3});
  EXPECT_EQ(link_->asked, (Numbers{1, 3}));
  hub_->request_submap(2, {1, 3});
  EXPECT_EQ(link_->asked, (Numbers{4, 6}));
  hub_->take(id_, CloudsUnavailable{{3, 6}}, link_);
  EXPECT_TRUE(news_.has("no cloud 1/3") && news_.has("no cloud 2/3"));
  hub_->take(id_, CloudRefused{7, "it does not decode"}, link_);
  EXPECT_TRUE(news_.has("no cloud 2/4"));
  hub_->left(id_, link_.get());
  EXPECT_TRUE(news_.has("left 1") && news_.has("left 2"));
  hub_->request_submap(2, {2});
  EXPECT_TRUE(news_.has("no cloud 2/2")) << "nobody is there to ask";
}

TEST_F(HubParts, ForThreeKeyframesItIsOnlySaid) {
  keyframes(1, 5);
  cut(1, 4, false);
  EXPECT_EQ(hub_->keys().size(), 1U);
  EXPECT_EQ(hub_->policy_of(id_).cut, "from keyframe 4 on it is left out of merging: its odometry jumps 400 m");
  hub_->tell_cut(1, {});
  EXPECT_EQ(hub_->policy_of(id_).cut, "");
}

TEST_F(HubParts, TheRobotIsToldTransformsOfThePartWhereItIsUnderItsOwnName) {
  const auto bee = std::make_shared<RobotEnd>();
  const SessionId other = hub_->admit(robot_hello("bee"), bee).value().session;
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  Atlas atlas{1, {{1, {{1, Pose::Identity()}, {other, T}}}}};
  hub_->publish(atlas, atlas.components, {});
  keyframes(1, 7);
  cut(1, 4);
  const SessionId part = 3;
  ASSERT_EQ(link_->updates.size(), 2U) << "what it was told of before the jump means nothing any more";
  ASSERT_EQ(link_->updates[1].sessions_size(), 1);
  EXPECT_EQ(link_->updates[1].sessions(0).session().session(), "s1");
  atlas = {2, {{1, {{1, Pose::Identity()}, {other, T}, {part, T.inverse()}}}}};
  hub_->publish(atlas, atlas.components, {});
  const auto name = [](const v1::TransformUpdate& update, int i) {
    return update.sessions(i).session().robot() + "/" + update.sessions(i).session().session();
  };
  ASSERT_EQ(link_->updates.size(), 3U);
  const auto& told = link_->updates[2];
  ASSERT_EQ(told.sessions_size(), 3);
  EXPECT_EQ(name(told, 0), "ant/s1~1");
  EXPECT_EQ(name(told, 1), "bee/s1");
  EXPECT_EQ(name(told, 2), "ant/s1");
  EXPECT_EQ(told.anchor().session(), "s1~1");
  EXPECT_TRUE(from_proto(told.sessions(2).t_component_session())->isApprox(T.inverse(), 1e-9));
  ASSERT_EQ(bee->updates.size(), 2U);
  EXPECT_EQ(name(bee->updates[1], 0), "ant/s1") << "to others each session has its name";
  EXPECT_EQ(name(bee->updates[1], 2), "ant/s1~4");
  come();
  ASSERT_TRUE(hub_->admit(hello(), link_)->transform);
}

TEST_F(HubParts, WhoAsksWhereItIsIsAnsweredOfThePartByItsOwnNumbers) {
  keyframes(1, 7);
  hub_->take(id_, WhereAsked{true}, link_);
  settle();
  cut(1, 4);
  EXPECT_TRUE(news_.has("asks no more 1") && news_.has("asks 2"));
  SessionLocalization found{.found = true, .component = 1, .on = 1, .keyframe = 3};
  hub_->tell_localization(2, found);
  EXPECT_EQ(link_->localization.keyframe(), 6U);
  EXPECT_EQ(link_->localization.session().session(), "s1~1");
  hub_->take(id_, WhereAsked{false}, link_);
  settle();
  EXPECT_TRUE(news_.has("asks no more 2"));
}

TEST_F(HubParts, AGoodbyeEndsThePartAndADeletedPartItsRobot) {
  keyframes(1, 7);
  cut(1, 4);
  hub_->take(id_, GoodbyeReceived{true}, link_);
  settle();
  EXPECT_TRUE(news_.has("ended 2"));
  EXPECT_TRUE(store_->sessions()->at(1).complete);
  hub_->forget(2);
  EXPECT_TRUE(link_->closed);
  EXPECT_EQ(hub_->admit(hello(), link_).error().code, ErrorCode::refused);
}

TEST_F(HubParts, NamesOfPartsAreTheServersAndALongNameGetsNone) {
  keyframes(1, 7);
  cut(1, 4);
  Hello as_part = hello();
  as_part.session.session = "s1~4";
  const auto refused = hub_->admit(as_part, std::make_shared<RobotEnd>());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("ant/s1~4 was made by the server"), std::string::npos)
      << refused.error().message;
  Hello own = hello();
  own.session.session = "s9~4";
  own.spool_id = 78;
  ASSERT_TRUE(hub_->admit(own, std::make_shared<RobotEnd>())) << "a robot may call its session what it likes";
  Hello longest = hello();
  longest.session.session = std::string(limits::name_bytes - 1, 'x');
  longest.spool_id = 79;
  const auto link = std::make_shared<RobotEnd>();
  const SessionId id = hub_->admit(longest, link)->session;
  for (std::uint64_t i = 1; i <= 7; ++i) hub_->take(id, KeyframeReceived{line_keyframe(i)}, link);
  settle();
  const std::size_t sessions = hub_->keys().size();
  cut(id, 4);
  EXPECT_EQ(hub_->keys().size(), sessions);
  EXPECT_EQ(stored(id).size(), 7U);
}

TEST_F(HubParts, WhoCallsItsSessionsAsPartsAreCalledKeepsThemApart) {
  for (const auto& [name, keyframes] : std::map<std::string, std::uint64_t>{{"s9", 5}, {"s9~4", 2}}) {
    Hello own = hello();
    own.session.session = name;
    own.spool_id = 78;
    const auto link = std::make_shared<RobotEnd>();
    const SessionId id = hub_->admit(own, link).value().session;
    for (std::uint64_t i = 1; i <= keyframes; ++i) hub_->take(id, KeyframeReceived{line_keyframe(i)}, link);
    settle();
  }
  start();
  for (const auto& [name, keyframes] : std::map<std::string, std::uint64_t>{{"s9", 5}, {"s9~4", 2}}) {
    Hello own = hello();
    own.session.session = name;
    own.spool_id = 78;
    const auto admitted = hub_->admit(own, std::make_shared<RobotEnd>());
    ASSERT_TRUE(admitted) << admitted.error().message;
    EXPECT_EQ(admitted->durable.keyframes, keyframes) << name;
  }
}

}  // namespace
}  // namespace headframe
