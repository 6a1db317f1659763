#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

class Spare : public Protocol {
 protected:
  void stand(const Durable& durable = {}) {
    Hello hello = robot_hello();
    hello.spare = true;
    const auto events = feed(hello_frame(hello));
    ASSERT_EQ(events.size(), 1U);
    EXPECT_TRUE(std::get<HelloReceived>(events[0]).hello.spare);
    protocol.welcome(durable);
    (void)protocol.take_output();
  }
};

TEST_F(Spare, TheWelcomeSaysHowManyMayStand) {
  limits.spares = 3;
  protocol = RobotProtocol(limits, now);
  (void)feed(hello_frame());
  protocol.welcome({});
  EXPECT_EQ(messages(protocol.take_output()).at(0).welcome().spares(), 3U);
}

TEST_F(Spare, AProbeIsAnsweredAtOnceOrWithTheKeyframeBehindIt) {
  stand({2, {}});
  auto events = feed(probe_frame(false));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_FALSE(std::get<ProbeReceived>(events[0]).keyframe_follows);
  protocol.resume(5, true);  // others brought 3 to 5
  EXPECT_EQ(messages(protocol.take_output()).at(0).keyframe_ack().durable_keyframes(), 5U);

  EXPECT_EQ(feed(probe_frame(true)).size(), 1U);
  protocol.resume(7, false);
  EXPECT_TRUE(protocol.take_output().empty());
  events = feed(keyframe_frame(line_keyframe(8)));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<KeyframeReceived>(events[0]).keyframe.sequence, 8U);
  EXPECT_TRUE(protocol.take_output().empty());
  protocol.keyframes_durable(8);
  EXPECT_EQ(messages(protocol.take_output()).at(0).keyframe_ack().durable_keyframes(), 8U);
}

TEST_F(Spare, AKeyframeThatOthersBroughtIsAcknowledgedOnceItIsCompared) {
  stand();
  (void)feed(probe_frame(true));
  protocol.resume(9, false);
  EXPECT_EQ(feed(keyframe_frame(line_keyframe(8))).size(), 1U);
  protocol.keyframes_durable(8);
  EXPECT_EQ(messages(protocol.take_output()).at(0).keyframe_ack().durable_keyframes(), 9U);
}

TEST_F(Spare, CloudsComeOnlyWhereTheSessionIsCarriedAndBeginAnewThere) {
  const std::string cloud = small_cloud();
  const std::string begin = chunk_frame(1, cloud.size(), 0, cloud.substr(0, 100)),
                    rest = chunk_frame(1, cloud.size(), 100, cloud.substr(100));
  greet({1, {}});
  EXPECT_TRUE(feed(begin).empty());
  protocol.stand_by();
  EXPECT_TRUE(feed(rest).empty()) << "it was on its way";
  EXPECT_EQ(feed(take_over_frame()).size(), 1U);
  const auto events = feed(begin + rest);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<CloudReceived>(events[0]).encoded, cloud);
  EXPECT_FALSE(protocol.ended());
}

TEST_F(Spare, ItIsNotAskedUntilItTakesOverButMayNotBeSilentForGood) {
  stand();
  later(74);
  EXPECT_TRUE(protocol.take_output().empty());
  const auto events = feed(take_over_frame());
  ASSERT_EQ(events.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<TakenOver>(events[0]));
  later(10);
  EXPECT_TRUE(messages(protocol.take_output()).at(0).has_ping());
  later(65);
  EXPECT_TRUE(protocol.ended());
}

TEST_F(Spare, ProbesComeAfterTheHello) {
  EXPECT_TRUE(feed(probe_frame(false)).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);
}

}  // namespace
}  // namespace headframe
