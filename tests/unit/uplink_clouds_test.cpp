#include "common/cloud/cloud_codec.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

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

/// Each server gets the most that it reads, byte for byte what a robot without intensities would have sent.
TEST_F(UplinkProtocolTest, IntensitiesGoOnlyToAServerThatReadsThem) {
  KeyframeCloud cloud{{{{0, 0, 0}, {{1, 2, 3}, {4, 5, 6}}, {70, 80}}}};
  const std::string full = encode_cloud(cloud).value();
  cloud.sweeps[0].intensity.clear();
  const std::string plain = encode_cloud(cloud).value();
  ASSERT_NE(full, plain);
  table_.keyframes = 1;
  table_.clouds = {{1, full}};
  const auto sent_to = [&](const std::vector<std::string>& capabilities) {
    start();
    (void)sent();
    welcome(0, capabilities);
    chunks_.clear();
    EXPECT_EQ(sent(), (Words{"k1", "c1:0"}));
    return chunks_;
  };
  EXPECT_EQ(sent_to({"cloud_form_1", "cloud_form_2", "cloud_form_3"}), full);
  EXPECT_EQ(sent_to({"cloud_form_1", "cloud_form_2"}), plain);
  EXPECT_EQ(sent_to({}), plain) << "older than the lists";
  table_.clouds = {{1, plain}};
  EXPECT_EQ(sent_to({"cloud_form_2"}), plain);
  table_.clouds = {{1, "no cloud"}};
  EXPECT_EQ(sent_to({"cloud_form_2"}), "no cloud") << "the server refuses it";
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

}  // namespace
}  // namespace headframe
