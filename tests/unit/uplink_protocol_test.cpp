#include "client/uplink/transform_update.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;

TEST_F(UplinkProtocolTest, OnlyTheHelloGoesBeforeTheWelcome) {
  table_.keyframes = 2;
  start();
  link_->trigger("early");
  EXPECT_EQ(sent(), Words{"hello"});
  welcome();
  EXPECT_EQ(sent(), (Words{"trigger", "k1", "k2"}));
}

TEST_F(UplinkProtocolTest, ItGoesOnWhereTheServerIs) {
  table_.keyframes = 5;
  start();
  sent();
  welcome(3);
  EXPECT_EQ(sent(), (Words{"k4", "k5"}));
  table_.keyframes = 6;
  EXPECT_EQ(sent(), Words{"k6"});
}

TEST_F(UplinkProtocolTest, KeyframesWaitForAcksWhenTheWindowIsFull) {
  limits_.keyframes_in_flight = 2;
  table_.keyframes = 4;
  start();
  sent();
  welcome();
  EXPECT_EQ(sent(), (Words{"k1", "k2"}));
  ack(1);
  EXPECT_EQ(sent(), Words{"k3"});
  ack(3);
  EXPECT_EQ(sent(), Words{"k4"});
  ASSERT_NE(std::get_if<KeyframesDurable>(&events_.back()), nullptr);
  EXPECT_EQ(std::get<KeyframesDurable>(events_.back()).up_to, 3U);
}

TEST_F(UplinkProtocolTest, PriorityIsControlKeyframesRequestedBackground) {
  table_.keyframes = 2;
  table_.clouds[1] = std::string(20 * 1024, 'a');
  table_.clouds[2] = std::string(8 * 1024, 'b');
  start();
  sent();
  welcome();
  EXPECT_EQ(sent(3), (Words{"k1", "k2", "c1:0"}));
  request({2});
  EXPECT_EQ(sent(1), Words{"c2:0"}) << "a requested cloud overtakes";
  table_.keyframes = 3;
  link_->trigger("now");
  EXPECT_EQ(sent(), (Words{"trigger", "k3", "c1:8", "c1:16"}));
}

TEST_F(UplinkProtocolTest, SilenceIsAskedAboutAndThenEndsTheLink) {
  start();
  sent();
  welcome();
  now_ += 9999ms;
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{});
  now_ += 1ms;
  take(link_->tick(now_));
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{"ping"});
  v1::ServerMessage pong;
  pong.mutable_pong();
  hear(pong);
  now_ += 74999ms;
  take(link_->tick(now_));
  EXPECT_FALSE(link_->ended());
  now_ += 1ms;
  take(link_->tick(now_));
  ASSERT_TRUE(link_->ended());
  EXPECT_FALSE(end()->permanent);
}

TEST_F(UplinkProtocolTest, AnAnswerThatIsLateIsAskedForAndThenPutsTheLinkInDoubt) {
  table_.keyframes = 2;
  start();
  sent();
  welcome();
  now_ += 5s;
  EXPECT_FALSE(link_->doubtful(now_)) << "nothing was sent that is answered";
  EXPECT_EQ(sent(), (Words{"k1", "k2"}));
  now_ += 2499ms;
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{});
  now_ += 1ms;
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{"ping"});
  now_ += 2499ms;
  EXPECT_FALSE(link_->doubtful(now_));
  now_ += 1ms;
  EXPECT_TRUE(link_->doubtful(now_));
  ack(1);
  EXPECT_FALSE(link_->doubtful(now_)) << "anything heard will do";
  now_ += 4999ms;
  EXPECT_FALSE(link_->doubtful(now_));
  now_ += 1ms;
  EXPECT_TRUE(link_->doubtful(now_)) << "keyframe 2 is still not acknowledged";
  ack(2);
  now_ += 8s;
  EXPECT_FALSE(link_->doubtful(now_));
}

TEST_F(UplinkProtocolTest, AServerThatDoesNotKnowTheQuestionIsNotAsked) {
  start();
  sent();
  welcome();
  EXPECT_FALSE(link_->localize(true));
  EXPECT_EQ(sent(), Words{});
}

TEST_F(UplinkProtocolTest, WhereTheRobotIsComesAsItWasTold) {
  start();
  sent();
  v1::ServerMessage m;
  m.mutable_welcome()->set_protocol_version(protocol_version);
  m.mutable_welcome()->add_capabilities("localize");
  hear(m);
  EXPECT_TRUE(link_->localize(true));
  EXPECT_TRUE(link_->localize(false));
  EXPECT_EQ(sent(), (Words{"where?", "where no more"}));

  v1::ServerMessage answer;
  auto& l = *answer.mutable_localization();
  l.set_missing("drive on\n");
  l.set_awaited_m(7);
  hear(answer);
  const auto told = [&] { return std::get<Localization>(events_.back()); };
  EXPECT_EQ(told().state, Localization::State::not_yet);
  EXPECT_EQ(told().awaited_m, 7);
  EXPECT_EQ(told().missing.find('\n'), std::string::npos);

  l.set_found(true);
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  *l.mutable_t_component_session() = *l.mutable_t_component_sensor() = to_proto(T);
  for (auto* key : {l.mutable_anchor(), l.mutable_session()}) {
    key->set_robot("ant");
    key->set_session("s1");
  }
  for (int i = 0; i < 36; ++i) l.add_covariance(i);
  hear(answer);
  EXPECT_EQ(told().state, Localization::State::found);
  EXPECT_EQ(told().anchor, (SessionKey{"ant", "s1"}));
  EXPECT_TRUE(told().T_component_sensor.isApprox(T, 1e-9));
  EXPECT_EQ(told().covariance(2, 3), 15);

  l.add_covariance(1);
  hear(answer);
  ASSERT_TRUE(link_->ended()) << "37 numbers are no covariance";
  EXPECT_FALSE(end()->permanent);
}

TEST_F(UplinkProtocolTest, AClockThatJumpsEndsTheLinkAtWorst) {
  table_.keyframes = 1;
  start();
  sent();
  welcome();
  sent();
  now_ -= std::chrono::hours(1);
  take(link_->tick(now_));
  EXPECT_FALSE(link_->ended() || link_->doubtful(now_));
  ack(1);
  now_ += std::chrono::hours(24);
  take(link_->tick(now_));
  ASSERT_TRUE(link_->ended()) << "a suspended robot connects anew";
  EXPECT_FALSE(end()->permanent);
}

TEST_F(UplinkProtocolTest, OnHoldOnlyControlIsSent) {
  table_.keyframes = 1;
  table_.clouds[1] = "cloud";
  start();
  sent();
  welcome();
  v1::ServerMessage policy, ping;
  policy.mutable_link_policy()->set_bytes_per_s(5000);
  policy.mutable_link_policy()->set_hold("the disk is\nfull");
  policy.mutable_link_policy()->set_cut("between keyframes 7 and 8 its odometry jumps 400\nm");
  hear(policy);
  const auto* told = std::get_if<PolicyTold>(&events_.back());
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->bytes_per_s, 5000);
  EXPECT_EQ(told->hold, "the disk is?full");
  EXPECT_EQ(told->cut, "between keyframes 7 and 8 its odometry jumps 400?m");
  ping.mutable_ping();
  hear(ping);
  EXPECT_EQ(sent(), Words{"pong"});
  policy.mutable_link_policy()->clear_hold();
  hear(policy);
  EXPECT_EQ(sent(), (Words{"k1", "c1:0"}));
}

TEST_F(UplinkProtocolTest, AServerThatDoesNotWelcomeIsGivenUp) {
  start();
  now_ += 9999ms;
  take(link_->tick(now_));
  EXPECT_FALSE(link_->ended());
  now_ += 1ms;
  take(link_->tick(now_));
  ASSERT_TRUE(link_->ended());
  EXPECT_EQ(end()->error.code, ErrorCode::unavailable);
}

TEST_F(UplinkProtocolTest, PingsAreAnsweredAndAFloodIsBounded) {
  start();
  sent();
  welcome();
  v1::ServerMessage ping;
  ping.mutable_ping()->set_nonce(4);
  hear(ping);
  EXPECT_EQ(sent(), Words{"pong"});
  for (int i = 0; i < 1000; ++i) hear(ping);
  EXPECT_EQ(sent().size(), 64U);
}

TEST_F(UplinkProtocolTest, NothingFollowsAGoodbye) {
  table_.keyframes = 1;
  start();
  sent();
  welcome();
  link_->goodbye(true);
  EXPECT_EQ(sent(), Words{"goodbye complete"});
}

TEST_F(UplinkProtocolTest, WhatAServerMayNotSayEndsTheLink) {
  const auto ends = [&](auto&& act) {
    events_.clear();
    table_.keyframes = 1;
    start();
    sent();
    act();
    return link_->ended() && end() != nullptr;
  };
  EXPECT_TRUE(ends([&] { ack(0); })) << "before the welcome";
  EXPECT_FALSE(ends([&] { welcome(1); }));
  EXPECT_TRUE(ends([&] { welcome(2); })) << "more keyframes than the spool has";
  EXPECT_TRUE(end()->permanent);
  EXPECT_TRUE(ends([&] { welcome(), welcome(); }));
  EXPECT_TRUE(ends([&] { welcome(), sent(), ack(2); }));
  EXPECT_TRUE(ends([&] { welcome(), sent(), ack_cloud(1); }));
  EXPECT_TRUE(ends([&] { take(link_->receive("HTTP/1.1 400 Bad Request", now_)); }));
  v1::ServerMessage m;
  m.mutable_welcome()->set_protocol_version(protocol_version + 1);
  EXPECT_TRUE(ends([&] { hear(m); }));
  EXPECT_EQ(end()->error.code, ErrorCode::incompatible);
  m.Clear();
  m.mutable_error()->set_kind(v1::ERROR_KIND_REFUSED);
  m.mutable_error()->set_message("no\nroom");
  m.mutable_error()->set_permanent(true);
  EXPECT_TRUE(ends([&] { hear(m); }));
  EXPECT_EQ(end()->error.message, "the server says: no?room");
  EXPECT_TRUE(end()->permanent);
}

TEST_F(UplinkProtocolTest, TransformsOfTheComponentPlaceTheOthersInMyFrame) {
  start();
  sent();
  welcome();
  v1::ServerMessage m;
  auto& update = *m.mutable_transform_update();
  update.set_revision(3);
  update.mutable_anchor()->set_robot("a");
  update.mutable_anchor()->set_session("1");
  const Pose T_component_mine = pose_from_yaw(0.5, {1, 2, 3}), T_component_other = pose_from_yaw(-1, {4, 0, 0});
  for (const auto& [robot, T] : {std::pair{"rover", T_component_mine}, std::pair{"other", T_component_other}}) {
    auto& s = *update.add_sessions();
    s.mutable_session()->set_robot(robot);
    s.mutable_session()->set_session("s");
    *s.mutable_t_component_session() = to_proto(T);
  }
  hear(m);
  const auto* t = std::get_if<Transforms>(&events_.back());
  ASSERT_NE(t, nullptr);
  EXPECT_EQ(t->revision, 3U);
  const auto T = t->T_mine_other({"rover", "s"}, {"other", "s"});
  ASSERT_TRUE(T);
  EXPECT_TRUE(T->isApprox(T_component_mine.inverse() * T_component_other, 1e-9));
  EXPECT_FALSE(t->T_mine_other({"rover", "s"}, {"nobody", "s"}));
  update.mutable_sessions(0)->clear_t_component_session();
  hear(m);
  EXPECT_TRUE(link_->ended()) << "a pose without a rotation";
}

TEST(TransformUpdate, TellsWhatIsProvisionalAndWhatWasWithdrawn) {
  v1::TransformUpdate update;
  *update.mutable_anchor() = to_proto(SessionKey{"rover", "s"});
  auto& provisional = *update.add_provisional();
  *provisional.mutable_session() = to_proto(SessionKey{"other", "s"});
  *provisional.mutable_t_component_session() = to_proto(pose_from_yaw(0.5, {1, 2, 3}));
  provisional.set_probability(0.97);
  provisional.set_awaited_m(25);
  auto& withdrawn = *update.add_withdrawn();
  withdrawn.set_revision(4);
  *withdrawn.mutable_a() = update.anchor();
  *withdrawn.mutable_b() = to_proto(SessionKey{"third", "s"});
  withdrawn.set_reason("later evidence\ncontradicts it");
  const auto told = transforms_from(update);
  ASSERT_TRUE(told);
  ASSERT_EQ(told->provisional.size(), 1U);
  EXPECT_EQ(told->provisional[0].session.robot, "other");
  EXPECT_EQ(told->provisional[0].probability, 0.97);
  EXPECT_EQ(told->provisional[0].awaited_m, 25);
  EXPECT_FALSE(told->T_component({"other", "s"})) << "nothing to drive by";
  ASSERT_EQ(told->withdrawn.size(), 1U);
  EXPECT_EQ(told->withdrawn[0].revision, 4U);
  EXPECT_EQ(told->withdrawn[0].b.robot, "third");
  EXPECT_EQ(told->withdrawn[0].reason.find('\n'), std::string::npos);
  provisional.set_awaited_m(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(transforms_from(update));
  provisional.set_awaited_m(0);
  withdrawn.mutable_a()->set_robot("..");
  EXPECT_FALSE(transforms_from(update));
}

}  // namespace
}  // namespace headframe
