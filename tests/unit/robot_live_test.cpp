// How a robot is, as bytes: the server's side.
#include <functional>
#include <limits>

#include "common/wire/limits.hpp"
#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

v1::RobotMessage live(double stamp_s = 5) {
  v1::RobotMessage message;
  message.mutable_live()->set_stamp_s(stamp_s);
  message.set_backlog(3);
  return message;
}

TEST_F(Protocol, HowARobotIsComesAsItWasSaid) {
  greet();
  auto message = live();
  *message.mutable_live()->mutable_t_local_sensor() = to_proto(pose_from_yaw(0.5, {1, 2, 3}));
  message.mutable_live()->set_battery(0);
  message.mutable_live()->set_health("left track\x1b[2J slips");
  const auto events = feed(frame(message) + frame(live(6)));
  ASSERT_EQ(events.size(), 2U);
  const auto& said = std::get<LiveReceived>(events[0]);
  EXPECT_EQ(said.state.stamp_s, 5);
  EXPECT_EQ(said.backlog, 3U);
  EXPECT_TRUE(said.state.T_local_sensor->isApprox(pose_from_yaw(0.5, {1, 2, 3})));
  EXPECT_EQ(said.state.battery, 0) << "empty is not the same as unknown";
  EXPECT_EQ(said.state.health, "left track?[2J slips");
  const auto& bare = std::get<LiveReceived>(events[1]).state;
  EXPECT_FALSE(bare.T_local_sensor || bare.battery);
}

TEST_F(Protocol, WhatIsSaidMoreOftenThanEachSecondIsPassedOver) {
  greet();
  later(20);  // a long silence saves up ten
  std::string burst;
  for (int i = 0; i < 1000; ++i) burst += frame(live());
  EXPECT_EQ(feed(burst).size(), 10U);
  later(0.9);
  EXPECT_EQ(feed(burst).size(), 0U);
  later(0.2);
  EXPECT_EQ(feed(burst).size(), 1U);
  for (int i = 0; i < 60; ++i) {
    later(1);
    EXPECT_EQ(feed(frame(live())).size(), 1U);
  }
  EXPECT_FALSE(protocol.ended()) << "it costs the robot nothing else";
}

TEST_F(Protocol, ASparesIsPassedOver) {
  greet();
  later(10);
  protocol.stand_by();
  EXPECT_TRUE(feed(frame(live())).empty());
}

TEST_F(Protocol, StatesThatAreNoneAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(v1::LiveState&)>> bad{
      [&](auto& m) { m.set_stamp_s(nan); },
      [&](auto& m) { m.set_battery(static_cast<float>(nan)); },
      [](auto& m) { m.set_battery(1.01F); },
      [](auto& m) { m.set_battery(-0.01F); },
      [](auto& m) { (void)m.mutable_t_local_sensor(); },
      [](auto& m) { m.set_health(std::string(limits::health_bytes + 1, 'h')); }};
  for (const auto& spoil : bad) {
    auto message = live();
    RobotProtocol fresh{limits, now};
    spoil(*message.mutable_live());
    fresh.receive(hello_frame(), now);
    ASSERT_TRUE(fresh.next());
    fresh.welcome({});
    fresh.receive(frame(message), now);
    EXPECT_FALSE(fresh.next());
    EXPECT_TRUE(fresh.ended()) << message.ShortDebugString();
  }
  greet();
  later(1);
  auto fits = live();
  fits.mutable_live()->set_battery(1);
  fits.mutable_live()->set_health(std::string(limits::health_bytes, 'h'));
  EXPECT_EQ(feed(frame(fits)).size(), 1U);
}

TEST_F(Protocol, BeforeTheHelloItIsOutOfOrder) {
  EXPECT_TRUE(feed(frame(live())).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);
}

TEST(LiveState, WhatIsTooLongIsCutBetweenCharacters) {
  std::string long_text(limits::health_bytes - 1, 'x');
  LiveState state;
  state.health = long_text + "\u00e4rger";
  EXPECT_EQ(to_proto(state).health(), long_text);
  state.health = "no \xff UTF-8";
  EXPECT_EQ(to_proto(state).health(), "no ? UTF-8");
  EXPECT_FALSE(to_proto(state).has_battery());
}

}  // namespace
}  // namespace headframe
