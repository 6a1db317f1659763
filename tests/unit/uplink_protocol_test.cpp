#include "client/uplink/uplink_protocol.hpp"

#include <gtest/gtest.h>

#include <map>

#include "common/wire/limits.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;

class Table : public UplinkSource {
 public:
  std::uint64_t keyframes = 0;
  std::map<std::uint64_t, std::string> clouds;
  std::uint64_t last_sequence() const override { return keyframes; }
  Result<Keyframe> keyframe(std::uint64_t sequence) const override {
    Keyframe k;
    k.sequence = sequence;
    k.descriptor.q = {1};
    return k;
  }
  bool holds_cloud(std::uint64_t s) const override { return clouds.count(s) != 0; }
  std::uint64_t next_held_cloud(std::uint64_t from) const override {
    const auto it = clouds.lower_bound(from);
    return it == clouds.end() ? 0 : it->first;
  }
  Result<std::string> cloud(std::uint64_t s) const override {
    const auto it = clouds.find(s);
    if (it == clouds.end() || it->second == "damaged") return failure(ErrorCode::bad_input, "damaged");
    return it->second;
  }
};

Hello rover(CloudPolicy clouds) {
  return {{"rover", "s"}, {"os1", 32, 20, 20, 100}, {{"f", 1}, 1, 0}, clouds, "test", 9};
}

class UplinkProtocolTest : public testing::Test {
 protected:
  void start(CloudPolicy clouds = CloudPolicy::all) { link_.emplace(limits_, rover(clouds), table_, now_); }

  /// Everything it wants to send now, in words: "k3" keyframe, "c2:0" chunk of cloud 2 at KiB 0, "none2" unavailable.
  std::vector<std::string> sent(std::size_t most = 1000) {
    std::vector<std::string> words;
    while (words.size() < most) {
      const auto frame = link_->next_frame(now_, chunk_bytes_, events_);
      if (!frame) break;
      FrameReader reader;
      reader.feed(*frame);
      v1::RobotMessage m;
      EXPECT_TRUE(m.ParseFromString(**reader.next()));
      words.push_back(word(m));
    }
    return words;
  }

  static std::string word(const v1::RobotMessage& m) {
    if (m.has_hello()) return "hello";
    if (m.has_keyframe()) return "k" + std::to_string(m.keyframe().sequence());
    if (m.has_cloud_chunk())
      return "c" + std::to_string(m.cloud_chunk().sequence()) + ":" + std::to_string(m.cloud_chunk().offset() / 1024);
    if (m.has_submap_unavailable()) return "none" + std::to_string(m.submap_unavailable().sequences(0));
    if (m.has_trigger()) return "trigger";
    if (m.has_goodbye()) return m.goodbye().complete() ? "goodbye complete" : "goodbye";
    return m.has_ping() ? "ping" : "pong";
  }

  void hear(const v1::ServerMessage& m) {
    std::string frame;
    ASSERT_TRUE(append_frame(frame, m.SerializeAsString()));
    take(link_->receive(frame, now_));
  }
  void take(const std::vector<UplinkEvent>& events) { events_.insert(events_.end(), events.begin(), events.end()); }
  void welcome(std::uint64_t durable = 0) {
    v1::ServerMessage m;
    m.mutable_welcome()->set_protocol_version(protocol_version);
    m.mutable_welcome()->set_durable_keyframes(durable);
    hear(m);
  }
  void ack(std::uint64_t keyframe) {
    v1::ServerMessage m;
    m.mutable_keyframe_ack()->set_durable_keyframes(keyframe);
    hear(m);
  }
  void ack_cloud(std::uint64_t sequence) {
    v1::ServerMessage m;
    m.mutable_cloud_ack()->add_sequences(sequence);
    hear(m);
  }
  void request(const std::vector<std::uint64_t>& sequences) {
    v1::ServerMessage m;
    for (auto s : sequences) m.mutable_submap_request()->add_sequences(s);
    hear(m);
  }
  const LinkEnded* end() const { return events_.empty() ? nullptr : std::get_if<LinkEnded>(&events_.back()); }

  using Words = std::vector<std::string>;
  UplinkLimits limits_;
  std::size_t chunk_bytes_ = limits::chunk_bytes;
  Table table_;
  UplinkProtocol::Time now_{};
  std::optional<UplinkProtocol> link_;
  std::vector<UplinkEvent> events_;
};

TEST_F(UplinkProtocolTest, OnlyTheHelloGoesBeforeTheWelcome) {
  table_.keyframes = 2;
  start();
  link_->trigger("early");
  EXPECT_EQ(sent(), Words{"hello"});
  welcome();
  EXPECT_EQ(sent(), (Words{"trigger", "k1", "k2"}));
}

TEST_F(UplinkProtocolTest, ARefusedCloudIsDroppedHoweverFarItWas) {
  table_.keyframes = 3;
  table_.clouds = {{1, "whole"}, {2, std::string(20'000, 'x')}, {3, "next"}};
  start();
  (void)sent(1);
  welcome();
  EXPECT_EQ(sent(5), (Words{"k1", "k2", "k3", "c1:0", "c2:0"}));
  const auto refuse = [&](std::uint64_t sequence) {
    events_.clear();
    v1::ServerMessage m;
    m.mutable_cloud_refusal()->set_sequence(sequence);
    m.mutable_cloud_refusal()->set_reason("damaged");
    hear(m);
    return events_.size() == 1 && std::get<CloudRefused>(events_[0]).sequence == sequence;
  };
  EXPECT_TRUE(refuse(2)) << "half sent";
  EXPECT_TRUE(refuse(1)) << "wholly sent";
  EXPECT_FALSE(refuse(1)) << "said twice";
  EXPECT_EQ(sent(), Words{"c3:0"});
  EXPECT_FALSE(link_->ended());
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

TEST_F(UplinkProtocolTest, CloudsWaitForAcksWhenTheWindowIsFull) {
  limits_.clouds_in_flight = 2;
  table_.keyframes = 3;
  for (std::uint64_t i = 1; i <= 3; ++i) table_.clouds[i] = "x";
  start();
  sent();
  welcome();
  EXPECT_EQ(sent(), (Words{"k1", "k2", "k3", "c1:0", "c2:0"}));
  ack_cloud(1);
  EXPECT_EQ(sent(), Words{"c3:0"});
}

TEST_F(UplinkProtocolTest, OnRequestSendsWhatIsAskedForOnce) {
  table_.keyframes = 2;
  table_.clouds[2] = "x";
  start(CloudPolicy::on_request);
  sent();
  welcome();
  EXPECT_EQ(sent(), (Words{"k1", "k2"}));
  request({2, 1, 2, 77});
  EXPECT_EQ(sent(), (Words{"none1", "c2:0"}));
  request({2});
  EXPECT_EQ(sent(), Words{}) << "it is on its way";
}

TEST_F(UplinkProtocolTest, NeverMeansNever) {
  table_.keyframes = 1;
  table_.clouds[1] = "x";
  start(CloudPolicy::never);
  sent();
  welcome();
  EXPECT_EQ(sent(), Words{"k1"});
  request({1});
  EXPECT_EQ(sent(), Words{"none1"});
}

TEST_F(UplinkProtocolTest, ADamagedCloudIsSaidAndPassedOver) {
  table_.keyframes = 2;
  table_.clouds[1] = "damaged";
  table_.clouds[2] = "x";
  start();
  sent();
  welcome();
  EXPECT_EQ(sent(), (Words{"k1", "k2", "none1", "c2:0"}));
  ASSERT_NE(std::get_if<CloudUnreadable>(&events_.back()), nullptr);
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
  now_ += 29999ms;
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
  now_ += 8s;
  EXPECT_FALSE(link_->doubtful(now_)) << "nothing was sent that is answered";
  EXPECT_EQ(sent(), (Words{"k1", "k2"}));
  now_ += 1499ms;
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{});
  now_ += 1ms;
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{"ping"});
  now_ += 1499ms;
  EXPECT_FALSE(link_->doubtful(now_));
  now_ += 1ms;
  EXPECT_TRUE(link_->doubtful(now_));
  ack(1);
  EXPECT_FALSE(link_->doubtful(now_)) << "anything heard will do";
  now_ += 2999ms;
  EXPECT_FALSE(link_->doubtful(now_));
  now_ += 1ms;
  EXPECT_TRUE(link_->doubtful(now_)) << "keyframe 2 is still not acknowledged";
  ack(2);
  now_ += 8s;
  EXPECT_FALSE(link_->doubtful(now_));
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

TEST_F(UplinkProtocolTest, AChunkIsAsLargeAsTheCallerAllows) {
  table_.keyframes = 1;
  table_.clouds[1] = std::string(3000, 'x');
  start();
  sent();
  welcome();
  chunk_bytes_ = 0;
  EXPECT_EQ(sent(), Words{"k1"}) << "keyframes do not wait for room";
  chunk_bytes_ = 1024;
  EXPECT_EQ(sent(), (Words{"c1:0", "c1:1", "c1:2"}));
}

TEST_F(UplinkProtocolTest, AKeyframeOvertakesTheRestOfACloud) {
  table_.keyframes = 1;
  table_.clouds[1] = std::string(3000, 'x');
  chunk_bytes_ = 1024;
  start();
  sent();
  welcome();
  EXPECT_EQ(sent(2), (Words{"k1", "c1:0"}));
  table_.keyframes = 2;
  EXPECT_EQ(sent(), (Words{"k2", "c1:1", "c1:2"}));
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
  hear(policy);
  const auto* told = std::get_if<PolicyTold>(&events_.back());
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->bytes_per_s, 5000);
  EXPECT_EQ(told->hold, "the disk is full");
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
  EXPECT_EQ(end()->error.message, "the server says: no room");
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

}  // namespace
}  // namespace headframe
