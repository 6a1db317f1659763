// How the robot is, as bytes: the robot's side.
#include "common/wire/capabilities.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;

class LiveUplink : public UplinkProtocolTest {
 protected:
  void meet(bool takes_live) {
    start();
    (void)sent();
    v1::ServerMessage m;
    m.mutable_welcome()->set_protocol_version(protocol_version);
    if (takes_live) m.mutable_welcome()->add_capabilities(std::string(live_capability));
    hear(m);
    table_.state.emplace();
    table_.state->T_local_sensor = Pose::Identity();
  }
  /// How many were sent in so many steps of 0.1 s; what is done before each step.
  int said(
      int steps, const std::function<void()>& before = [] {}) {
    int count = 0;
    for (int i = 0; i < steps; ++i) {
      before();
      now_ += 100ms;
      for (const auto& word : sent()) count += word == "live" ? 1 : 0;
    }
    return count;
  }
};

TEST_F(LiveUplink, AServerThatDoesNotListItHearsNothing) {
  meet(false);
  EXPECT_EQ(said(100), 0);
}

TEST_F(LiveUplink, ARobotThatMovesSaysSoEachSecondAndOneThatStandsEveryFive) {
  meet(true);
  EXPECT_EQ(sent(), Words{"live"});
  EXPECT_EQ(said(100), 2);
  EXPECT_EQ(said(100, [&] { table_.state->T_local_sensor->translation().x() += 0.01; }), 10);
  EXPECT_EQ(said(100, [&] { table_.state->T_local_sensor->translation().x() += 0.00005; }), 2) << "it trembles";
  table_.state->health = "hot";
  EXPECT_EQ(said(20), 1);
  table_.state->battery = 0.5;
  EXPECT_EQ(said(20), 1);
  table_.state.reset();
  EXPECT_EQ(said(100), 0);
}

TEST_F(LiveUplink, ItGoesAheadOfKeyframesAndNotIntoADarkLink) {
  meet(true);
  table_.keyframes = 3;
  EXPECT_EQ(sent(), (Words{"live", "k1", "k2", "k3"}));
  chunk_bytes_ = 0;  // the kernel still holds what was sent before
  EXPECT_EQ(said(100), 0);
  chunk_bytes_ = 1000;
  EXPECT_EQ(said(1), 1);
}

TEST_F(LiveUplink, ASpareAndWhoSaidGoodbyeSayNothing) {
  meet(true);
  link_->stand_by();
  EXPECT_EQ(said(100), 0);
  (void)link_->take_over();
  EXPECT_EQ(said(1), 1);
  link_->goodbye(true);
  EXPECT_EQ(said(100), 0);
}

TEST_F(LiveUplink, AHeldRobotIsSeenToLive) {
  meet(true);
  v1::ServerMessage hold;
  hold.mutable_link_policy()->set_hold("the disk is full");
  hear(hold);
  EXPECT_EQ(said(1), 1);
}

}  // namespace
}  // namespace headframe
