// Updates of poses as bytes: the robot's side.
#include "common/wire/capabilities.hpp"
#include "common/wire/pose_message.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

class PoseUplink : public UplinkProtocolTest {
 protected:
  void meet(std::uint64_t durable_keyframes, std::uint64_t durable_update = 0, bool takes_poses = true) {
    start(CloudPolicy::never);
    (void)sent();
    v1::ServerMessage m;
    m.mutable_welcome()->set_protocol_version(protocol_version);
    m.mutable_welcome()->set_durable_keyframes(durable_keyframes);
    m.mutable_welcome()->set_durable_pose_update(durable_update);
    if (takes_poses) m.mutable_welcome()->add_capabilities(std::string(poses_capability));
    hear(m);
  }
  void ack_update(std::uint64_t number) {
    v1::ServerMessage m;
    m.mutable_pose_update_ack()->set_durable_pose_update(number);
    hear(m);
  }
};

TEST_F(PoseUplink, AnUpdateGoesBehindItsKeyframesAndAheadOfLaterOnes) {
  table_.keyframes = 2;
  table_.move(2, {1, 2});
  table_.keyframes = 4;
  meet(0);
  EXPECT_EQ(sent(), (Words{"k1", "k2", "u1:0/2", "k3", "k4"}));
  table_.move(4, {4});
  EXPECT_EQ(sent(), Words{"u2:0/1"});
  ack_update(2);
  EXPECT_EQ(std::get<PosesDurable>(events_.back()).up_to_update, 2U);
}

TEST_F(PoseUplink, WhatWaitedAndHasItsKeyframesThereGoesAsOne) {
  table_.keyframes = 9;
  table_.move(3, {1, 2, 3});
  table_.move(5, {2, 5});
  table_.move(9, {9});
  meet(5, 0);
  EXPECT_EQ(sent(), (Words{"u2:0/4", "k6", "k7", "k8", "k9", "u3:0/1"}));
  meet(9, 2);
  EXPECT_EQ(sent(), Words{"u3:0/1"}) << "only what the server has not";
  meet(9, 3);
  EXPECT_TRUE(sent().empty());
}

TEST_F(PoseUplink, ALargeOneComesInPartsThatTheLinkCanTakeAndKeyframesWait) {
  table_.keyframes = 301;
  std::vector<std::uint64_t> all(300);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i + 1;
  table_.move(300, all);
  meet(300);
  EXPECT_EQ(sent(), (Words{"u1:0/300", "u1:120/300", "u1:240/300", "k301"}));
  chunk_bytes_ = 256;
  meet(300);
  EXPECT_EQ(sent(2), (Words{"u1:0/300", "u1:3/300"}));
  chunk_bytes_ = 0;
  EXPECT_TRUE(sent().empty()) << "the kernel still holds what was sent before";
  chunk_bytes_ = 8192;
  EXPECT_EQ(sent(1), Words{"u1:6/300"});
}

TEST_F(PoseUplink, AServerThatDoesNotListItGetsKeyframesAlone) {
  table_.keyframes = 3;
  table_.move(2, {1, 2});
  meet(0, 0, false);
  EXPECT_EQ(sent(), (Words{"k1", "k2", "k3"}));
}

TEST_F(PoseUplink, AHeldRobotKeepsThem) {
  table_.keyframes = 1;
  table_.move(1, {1});
  meet(1);
  v1::ServerMessage hold;
  hold.mutable_link_policy()->set_hold("the disk is full");
  hear(hold);
  EXPECT_TRUE(sent().empty());
}

TEST_F(PoseUplink, ASpareThatTakesOverSaysAgainWhatWasNotAcknowledged) {
  table_.keyframes = 2;
  table_.move(2, {1});
  meet(2);
  EXPECT_EQ(sent(), Words{"u1:0/1"});
  link_->stand_by();
  EXPECT_TRUE(sent().empty());
  (void)link_->take_over();
  EXPECT_EQ(sent(), (Words{"take over", "u1:0/1"}));
  ack_update(1);
  link_->stand_by();
  (void)link_->take_over();
  EXPECT_EQ(sent(), Words{"take over"});
}

TEST_F(PoseUplink, AnAckOfWhatWasNotSentEndsTheLink) {
  table_.keyframes = 2;
  meet(2);
  ack_update(1);
  ASSERT_NE(end(), nullptr);
  EXPECT_FALSE(end()->permanent);
}

TEST_F(PoseUplink, AServerThatHoldsMoreThanTheSpoolHasAnOldCopyBeforeIt) {
  table_.keyframes = 2;
  table_.move(2, {1});
  meet(2, 2);
  ASSERT_NE(end(), nullptr);
  EXPECT_TRUE(end()->permanent);
}

TEST_F(PoseUplink, OneThatCanNotBeReadEndsTheLinkForGood) {
  table_.keyframes = 2;
  table_.move(2, {});
  table_.damaged_poses = true;
  meet(2);
  EXPECT_TRUE(sent().empty());
  ASSERT_NE(end(), nullptr);
  EXPECT_TRUE(end()->permanent) << "what follows would lie wrong without it";
}

}  // namespace
}  // namespace headframe
