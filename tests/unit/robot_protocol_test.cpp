#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

TEST_F(Protocol, HelloIsAskedAboutAndTheWelcomeSaysWhatIsDurable) {
  const auto events = feed(hello_frame() + keyframe_frame(line_keyframe(6)));
  ASSERT_EQ(events.size(), 1U) << "what follows a hello waits for its answer";
  EXPECT_EQ(std::get<HelloReceived>(events[0]).hello.session, (SessionKey{"ant", "s1"}));
  protocol.welcome({5, {1, 2, 3, 5}});
  const auto sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].welcome().durable_keyframes(), 5U);
  ASSERT_EQ(sent[0].welcome().durable_clouds_size(), 2);
  EXPECT_EQ(sent[0].welcome().durable_clouds(0).last(), 3U);
  EXPECT_EQ(sent[0].welcome().durable_clouds(1).first(), 5U);
  const auto rest = feed("");
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(std::get<KeyframeReceived>(rest[0]).keyframe.sequence, 6U);
}

TEST_F(Protocol, EventsAreTheSameHoweverTheBytesAreCut) {
  const std::string cloud = small_cloud();
  std::string bytes = keyframe_frame(line_keyframe(1)) + keyframe_frame(line_keyframe(2));
  for (std::size_t at = 0; at < cloud.size(); at += 100)
    bytes += chunk_frame(1, cloud.size(), at, cloud.substr(at, 100));
  bytes += goodbye_frame(true);
  for (const std::size_t cut : {1UL, 13UL, bytes.size()}) {
    protocol = RobotProtocol(limits, now);
    greet();
    std::vector<RobotEvent> events;
    for (std::size_t at = 0; at < bytes.size(); at += cut)
      for (auto& event : feed(bytes.substr(at, cut))) events.push_back(std::move(event));
    ASSERT_EQ(events.size(), 4U) << "cut every " << cut;
    EXPECT_EQ(std::get<KeyframeReceived>(events[1]).keyframe.descriptor.q, line_keyframe(2).descriptor.q);
    EXPECT_EQ(std::get<CloudReceived>(events[2]).encoded, cloud);
    EXPECT_TRUE(std::get<GoodbyeReceived>(events[3]).complete);
  }
}

TEST_F(Protocol, AnotherProtocolVersionIsRefusedForGood) {
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(robot_hello());
  message.mutable_hello()->set_protocol_version(2);
  EXPECT_TRUE(feed(frame(message)).empty());
  const auto report = error();
  EXPECT_EQ(report.kind(), v1::ERROR_KIND_PROTOCOL_VERSION);
  EXPECT_TRUE(report.permanent());
}

TEST_F(Protocol, GarbageGetsATypedErrorAndNothingMoreIsRead) {
  EXPECT_TRUE(feed("GET / HTTP/1.1\r\n").empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_FRAME_TOO_LARGE);
  EXPECT_TRUE(feed(hello_frame()).empty());

  protocol = RobotProtocol(limits, now);
  std::string noise;
  ASSERT_TRUE(append_frame(noise, "\xff\xff\xff garbage"));
  EXPECT_TRUE(feed(noise).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_BAD_MESSAGE);
}

TEST_F(Protocol, HelloComesFirstAndOnce) {
  EXPECT_TRUE(feed(keyframe_frame(line_keyframe(1))).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);

  protocol = RobotProtocol(limits, now);
  greet();
  EXPECT_TRUE(feed(hello_frame()).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);
}

TEST_F(Protocol, HolesEndTheConnectionAndRepeatsAreHandedOnToBeCompared) {
  greet({5, {}});
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(6))).size(), 1U);
  const auto repeats = feed(keyframe_frame(line_keyframe(3)) + keyframe_frame(line_keyframe(6)));
  ASSERT_EQ(repeats.size(), 2U);
  EXPECT_EQ(std::get<KeyframeReceived>(repeats[0]).keyframe.sequence, 3U);
  EXPECT_TRUE(messages(protocol.take_output()).empty()) << "nobody has compared them yet";
  protocol.keyframes_durable(3);
  EXPECT_EQ(messages(protocol.take_output()).at(0).keyframe_ack().durable_keyframes(), 5U);
  protocol.keyframes_durable(6);
  EXPECT_EQ(messages(protocol.take_output()).at(0).keyframe_ack().durable_keyframes(), 6U);

  EXPECT_TRUE(feed(keyframe_frame(line_keyframe(8))).empty());
  const auto report = error();
  EXPECT_EQ(report.kind(), v1::ERROR_KIND_OUT_OF_ORDER);
  EXPECT_NE(report.message().find("7 comes next"), std::string::npos) << report.message();
}

TEST_F(Protocol, FieldsOfLaterVersionsAreSkippedAndUnknownBodiesAreNot) {
  greet();
  const std::string later_field("\xa0\x06\x01", 3);  // field 100, a varint
  v1::RobotMessage message;
  *message.mutable_keyframe() = to_proto(line_keyframe(1)).value();
  message.set_backlog(7);
  std::string bytes;
  ASSERT_TRUE(append_frame(bytes, message.SerializeAsString() + later_field));
  const auto events = feed(bytes);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<KeyframeReceived>(events[0]).backlog, 7U);
  bytes.clear();
  ASSERT_TRUE(append_frame(bytes, later_field));
  EXPECT_TRUE(feed(bytes).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_BAD_MESSAGE);
}

TEST_F(Protocol, ACloudPolicyThatIsNotKnownIsRefused) {
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(robot_hello());
  message.mutable_hello()->set_clouds(static_cast<v1::CloudPolicy>(9));
  EXPECT_TRUE(feed(frame(message)).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_BAD_MESSAGE);
}

TEST_F(Protocol, ReorderedKeyframesEndTheConnectionForNow) {
  greet();
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(1)) + keyframe_frame(line_keyframe(3)) + keyframe_frame(line_keyframe(2)))
                .size(),
            1U);
  const auto report = error();
  EXPECT_EQ(report.kind(), v1::ERROR_KIND_OUT_OF_ORDER);
  EXPECT_FALSE(report.permanent()) << "the robot repeats from what is durable";
}

TEST_F(Protocol, ATornFrameIsNothingAndWhatWasNotAcknowledgedComesAgain) {
  greet();
  const std::string second = keyframe_frame(line_keyframe(2));
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(1)) + second.substr(0, second.size() - 1)).size(), 1U);
  // The link drops before the ack of 1, which becomes durable all the same; the next connection starts there.
  protocol = RobotProtocol(limits, now);
  greet({1, {}});
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(1))).size(), 1U) << "a repeat";
  protocol.keyframes_durable(1);
  EXPECT_EQ(messages(protocol.take_output()).at(0).keyframe_ack().durable_keyframes(), 1U);
  EXPECT_EQ(feed(second).size(), 1U);
}

TEST_F(Protocol, AClockThatJumpsBackEndsNothing) {
  greet();
  later(-3600);
  EXPECT_FALSE(protocol.ended());
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(1))).size(), 1U);
  later(limits.silence_s);
  EXPECT_TRUE(protocol.ended());
}

TEST_F(Protocol, ThePolicyIsToldOnceAndTheLatestCounts) {
  greet();
  protocol.tell_policy({1000, "full"});
  protocol.tell_policy({500, "", "its odometry jumps"});
  const auto sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].link_policy().bytes_per_s(), 500U);
  EXPECT_EQ(sent[0].link_policy().hold(), "");
  EXPECT_EQ(sent[0].link_policy().cut(), "its odometry jumps");
  EXPECT_TRUE(protocol.take_output().empty());
}

TEST_F(Protocol, DescriptorsMustHaveTheSizesOfTheHello) {
  greet();
  Keyframe keyframe = line_keyframe(1);
  keyframe.descriptor.q.push_back(1);
  EXPECT_TRUE(feed(keyframe_frame(keyframe)).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_BAD_MESSAGE);
}

TEST_F(Protocol, NothingFollowsACompleteSession) {
  greet();
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(1)) + goodbye_frame(true)).size(), 2U);
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(1))).size(), 1U) << "a repeat is harmless";
  EXPECT_FALSE(protocol.ended());
  EXPECT_TRUE(feed(keyframe_frame(line_keyframe(2))).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);
}

TEST_F(Protocol, SilenceIsAskedAboutAndThenEndsTheConnection) {
  greet();
  later(limits.ping_s - 0.1);
  EXPECT_TRUE(protocol.take_output().empty());
  later(0.1);
  const auto sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_TRUE(sent[0].has_ping());
  later(1);
  EXPECT_TRUE(protocol.take_output().empty()) << "asked once";
  v1::RobotMessage pong;
  pong.mutable_pong()->set_nonce(sent[0].ping().nonce());
  EXPECT_TRUE(feed(frame(pong)).empty());
  later(limits.silence_s - 0.1);
  EXPECT_FALSE(protocol.ended());
  later(0.2);
  EXPECT_TRUE(protocol.ended());
}

TEST_F(Protocol, BytesThatMakeNoMessageAreSilence) {
  greet();
  for (double silent_s = 0; silent_s <= limits.silence_s; ++silent_s) {
    protocol.receive(std::string(1, '\0'), now);
    later(1);
  }
  EXPECT_TRUE(protocol.ended());
}

TEST_F(Protocol, ARobotThatIsNotReadIsNotBlamedForItsSilence) {
  greet();
  now += std::chrono::hours(1);
  protocol.tick(now, false);
  EXPECT_FALSE(protocol.ended());
  later(limits.silence_s);
  EXPECT_TRUE(protocol.ended());
}

TEST_F(Protocol, AHelloIsWaitedForSoLong) {
  later(limits.hello_s - 0.1);
  EXPECT_FALSE(protocol.ended());
  later(0.1);
  EXPECT_TRUE(protocol.ended());
}

TEST_F(Protocol, OutputKeepsTheLatestWordOnly) {
  greet({9, {}});
  for (std::uint64_t nonce = 1; nonce <= 1000; ++nonce) {
    v1::RobotMessage ping;
    ping.mutable_ping()->set_nonce(nonce);
    feed(frame(ping));
    v1::ServerMessage update;
    update.mutable_transform_update()->set_revision(nonce);
    protocol.update_transform(std::make_shared<const TransformPages>(TransformPages{update.SerializeAsString()}));
    protocol.cloud_durable(3);
    protocol.request_submap({4, 2, 4});
  }
  const auto sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 4U);
  EXPECT_EQ(sent[0].cloud_ack().sequences_size(), 1);
  ASSERT_EQ(sent[1].submap_request().sequences_size(), 2);
  EXPECT_EQ(sent[1].submap_request().sequences(0), 4U) << "nearest first";
  EXPECT_EQ(sent[2].transform_update().revision(), 1000U);
  EXPECT_EQ(sent[3].pong().nonce(), 1000U);
  EXPECT_TRUE(protocol.take_output().empty());
}

}  // namespace
}  // namespace headframe
