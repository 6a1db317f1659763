#include "common/wire/limits.hpp"
#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

TEST_F(Protocol, ACloudThatDoesNotFitOrDecodeIsRefusedAndNothingElse) {
  const std::string cloud = small_cloud();
  const std::vector<std::string> bad{
      chunk_frame(1, cloud.size(), 5, "abc"),                      // a hole
      chunk_frame(1, 2, 0, "abc"),                                 // more than announced
      chunk_frame(1, limits::cloud_bytes + 1, 0, "abc"),           // over the limit
      chunk_frame(1, 0, 0, "abc"),                                 //
      chunk_frame(1, 3, 0, ""),                                    // would never end
      chunk_frame(1, 6, 0, "abc") + chunk_frame(1, 7, 3, "defg"),  // another size half-way
      chunk_frame(1, 7, 0, "garbage"),                             // does not decode
  };
  for (std::size_t i = 0; i < bad.size(); ++i) {
    protocol = RobotProtocol(limits, now);
    greet({1, {}});
    const auto events = feed(bad[i]);
    ASSERT_EQ(events.size(), 1U) << "case " << i;
    EXPECT_EQ(std::get<CloudRefused>(events[0]).sequence, 1U);
    const auto sent = messages(protocol.take_output());
    ASSERT_EQ(sent.size(), 1U) << "case " << i;
    EXPECT_EQ(sent[0].cloud_refusal().sequence(), 1U);
    EXPECT_FALSE(sent[0].cloud_refusal().reason().empty());
    EXPECT_EQ(feed(keyframe_frame(line_keyframe(2)) + chunk_frame(2, cloud.size(), 0, cloud)).size(), 2U);
    EXPECT_EQ(feed(chunk_frame(1, cloud.size(), 0, cloud)).size(), 1U) << "begun anew it may be well";
  }
  protocol = RobotProtocol(limits, now);
  greet({1, {}});
  EXPECT_TRUE(feed(chunk_frame(1, limits::cloud_bytes, 0, "abc")).empty());
  EXPECT_FALSE(protocol.ended()) << "exactly the limit";
  EXPECT_TRUE(feed(chunk_frame(2, 3, 0, "abc")).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER) << "no such keyframe";
}

TEST_F(Protocol, TheRestOfACloudThatWasRefusedHalfWayIsSkipped) {
  greet({2, {}});
  EXPECT_EQ(feed(chunk_frame(1, 9, 0, "abc") + chunk_frame(1, 9, 4, "ef")).size(), 1U);
  EXPECT_EQ(messages(protocol.take_output()).size(), 1U);
  EXPECT_TRUE(feed(chunk_frame(1, 9, 6, "gh") + chunk_frame(1, 9, 8, "i")).empty());
  EXPECT_TRUE(protocol.take_output().empty()) << "said once";
  const std::string cloud = small_cloud();
  EXPECT_EQ(feed(chunk_frame(1, cloud.size(), 0, cloud)).size(), 1U);
}

TEST_F(Protocol, AFewCloudsMayOvertakeEachOtherButNotMany) {
  greet({10, {}});
  const std::string cloud = small_cloud();
  for (std::uint64_t s = 1; s <= CloudAssembler::open_clouds; ++s)
    EXPECT_TRUE(feed(chunk_frame(s, cloud.size(), 0, cloud.substr(0, 50))).empty());
  EXPECT_EQ(feed(chunk_frame(2, cloud.size(), 50, cloud.substr(50))).size(), 1U);
  EXPECT_EQ(feed(chunk_frame(1, cloud.size(), 0, cloud)).size(), 1U) << "begun anew";
  for (const std::uint64_t s : {5, 6}) EXPECT_TRUE(feed(chunk_frame(s, cloud.size(), 0, "x")).empty());
  EXPECT_FALSE(protocol.ended());
  const auto events = feed(chunk_frame(7, cloud.size(), 0, "x"));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<CloudRefused>(events[0]).sequence, 7U);
  EXPECT_FALSE(protocol.ended());
}

TEST(CloudAssembler, HoldsSoManyBytesOfUnfinishedCloudsAndNoMore) {
  CloudAssembler clouds;
  const std::size_t total = limits::cloud_bytes;
  const std::string all_but_one(total - 1, 'x');
  EXPECT_FALSE(clouds.add(1, total, 0, all_but_one).value());
  EXPECT_FALSE(clouds.add(2, total, 0, all_but_one).value());
  EXPECT_FALSE(clouds.add(3, total, 0, "xx").value());
  EXPECT_FALSE(clouds.add(3, total, 2, "x"));
  EXPECT_FALSE(clouds.add(1, total, 0, "x").value()) << "begun anew, its bytes are free again";
  EXPECT_FALSE(clouds.add(3, total, 2, "x").value());
}

TEST_F(Protocol, UnavailableCloudsOfUnknownKeyframesAreLeftOut) {
  greet({3, {}});
  v1::RobotMessage message;
  for (const std::uint64_t s : {0, 2, 3, 4}) message.mutable_submap_unavailable()->add_sequences(s);
  const auto events = feed(frame(message));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<CloudsUnavailable>(events[0]).sequences, (std::vector<std::uint64_t>{2, 3}));
}

}  // namespace
}  // namespace headframe
