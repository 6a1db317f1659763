#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

class UplinkSpare : public UplinkProtocolTest {
 protected:
  /// Beside a connection that has sent `keyframes` to a server that has `durable` of them.
  void stand(std::uint64_t keyframes, std::uint64_t durable) {
    table_.keyframes = keyframes;
    start();
    link_->stand_by();
    EXPECT_EQ(sent(), Words{"hello of a spare"});
    welcome(durable);
  }
  void hear_ping() {
    v1::ServerMessage m;
    m.mutable_ping()->set_nonce(1);
    hear(m);
  }
  void hear_policy(const std::string& hold) {
    v1::ServerMessage m;
    m.mutable_link_policy()->set_bytes_per_s(4000);
    m.mutable_link_policy()->set_hold(hold);
    hear(m);
  }
  template <class Event>
  std::size_t count() const {
    return static_cast<std::size_t>(std::count_if(
        events_.begin(), events_.end(), [](const UplinkEvent& e) { return std::holds_alternative<Event>(e); }));
  }
};

TEST_F(UplinkSpare, NothingOfTheSessionGoesOverIt) {
  table_.clouds[1] = "cloud";
  stand(3, 0);
  EXPECT_EQ(sent(), Words{});
  request({1});
  EXPECT_EQ(sent(), Words{});
  v1::ServerMessage update;
  update.mutable_transform_update()->set_revision(1);
  hear(update);
  EXPECT_EQ(count<Transforms>(), 0U);
  EXPECT_FALSE(link_->ended()) << "what was on its way to the other is no fault";
  hear_ping();
  EXPECT_EQ(sent(), Words{"pong"});
}

TEST_F(UplinkSpare, ItAsksSeldomWhetherTheServerIsThere) {
  stand(0, 0);
  now_ += std::chrono::milliseconds(44999);
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{});
  now_ += std::chrono::milliseconds(1);
  take(link_->tick(now_));
  EXPECT_EQ(sent(), Words{"ping"});
}

TEST_F(UplinkSpare, AProbeBringsTheFirstKeyframeThatIsNotDurableInTheSamePacket) {
  stand(5, 1);
  link_->probe(3);
  EXPECT_EQ(sent(), Words{"probe with k4"});
  EXPECT_FALSE(link_->answered());
  hear_ping();
  EXPECT_FALSE(link_->answered());
  ack(4);
  EXPECT_TRUE(link_->answered());
  EXPECT_EQ(std::get<KeyframesDurable>(events_.back()).up_to, 4U);
}

TEST_F(UplinkSpare, AProbeGoesAloneWhenAllIsDurableOrTheServerHolds) {
  stand(3, 3);
  link_->probe(3);
  EXPECT_EQ(sent(), Words{"probe"});
  ack(3);
  EXPECT_TRUE(link_->answered());
  table_.keyframes = 4;
  link_->stand_by();
  EXPECT_FALSE(link_->answered());
  hear_policy("the disk is full");
  link_->probe(3);
  EXPECT_EQ(sent(), Words{"probe"});
}

TEST_F(UplinkSpare, WhoTakesOverGoesOnBehindItsProbe) {
  table_.clouds[1] = "cloud";
  stand(5, 1);
  hear_policy("");
  EXPECT_EQ(count<PolicyTold>(), 0U);
  link_->probe(3);
  EXPECT_EQ(sent(), Words{"probe with k4"});
  ack(4);
  take(link_->take_over());
  ASSERT_EQ(count<PolicyTold>(), 1U);
  EXPECT_EQ(std::get<PolicyTold>(events_.back()).bytes_per_s, 4000);
  EXPECT_EQ(sent(), (Words{"take over", "k5", "c1:0"}));
}

TEST_F(UplinkSpare, WhoStandsByAgainBeginsItsCloudsAnew) {
  table_.keyframes = 2;
  table_.clouds[1] = std::string(20 * 1024, 'a');
  start();
  sent();
  welcome();
  EXPECT_EQ(sent(3), (Words{"k1", "k2", "c1:0"}));
  link_->stand_by();
  EXPECT_EQ(sent(), Words{});
  ack(2);
  EXPECT_FALSE(link_->ended()) << "sent before it stood by";
  link_->probe(2);
  EXPECT_EQ(sent(), Words{"probe"});
  take(link_->take_over());
  EXPECT_EQ(sent(), (Words{"take over", "c1:0", "c1:8", "c1:16"}));
  link_->stand_by();
  ack_cloud(1);
  EXPECT_EQ(count<CloudsDurable>(), 1U) << "it was wholly sent before";
}

TEST_F(UplinkSpare, AnAckMayCountWhatOthersSentAndNoMore) {
  stand(5, 1);
  link_->probe(1);
  ack(5);
  EXPECT_FALSE(link_->ended());
  ack(6);
  EXPECT_TRUE(link_->ended());
}

}  // namespace
}  // namespace headframe
