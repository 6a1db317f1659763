// Questions about what others know, as bytes: the server's side.
#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

v1::RobotMessage coverage_request(std::uint64_t version, bool stop = false) {
  v1::RobotMessage message;
  message.mutable_coverage_request()->set_epoch(9);
  message.mutable_coverage_request()->set_version(version);
  message.mutable_coverage_request()->set_stop(stop);
  return message;
}

std::shared_ptr<const std::string> coverage_page(std::uint64_t version) {
  v1::ServerMessage message;
  message.mutable_coverage()->mutable_page()->set_version(version);
  return std::make_shared<const std::string>(message.SerializeAsString());
}

TEST_F(Protocol, QuestionsAboutOthersComeAsTheyWereAsked) {
  greet();
  v1::RobotMessage map, next;
  map.mutable_map_request()->set_id(4);
  map.mutable_map_request()->mutable_box()->set_high_x(3);
  map.mutable_map_request()->set_resolution_m(0.5F);
  next.mutable_map_next()->set_id(4);
  next.mutable_map_next()->set_offset(4096);
  const auto events = feed(frame(coverage_request(3)) + frame(coverage_request(0, true)) + frame(map) + frame(next));
  ASSERT_EQ(events.size(), 4U);
  const auto& asked = std::get<SurroundingsAsked>(events[0]);
  EXPECT_EQ(asked.kind, SurroundingsKind::coverage);
  EXPECT_TRUE(asked.asks);
  EXPECT_EQ(asked.held, (HeldVersion{9, 3}));
  EXPECT_FALSE(std::get<SurroundingsAsked>(events[1]).asks);
  EXPECT_EQ(std::get<BoxRegion>(std::get<MapAsked>(events[2]).region).high_m.x(), 3);
  EXPECT_EQ(std::get<MapNextAsked>(events[3]).offset, 4096U);
}

TEST_F(Protocol, AQuestionAboutOthersBeforeTheHelloIsOutOfOrder) {
  EXPECT_TRUE(feed(frame(coverage_request(0))).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);
}

TEST_F(Protocol, WhatOthersKnowGoesAfterAllElseOneAtATimeAndTheNewestOfAKind) {
  greet();
  ASSERT_EQ(feed(keyframe_frame(line_keyframe(1))).size(), 1U);
  protocol.tell_surroundings(SurroundingsKind::coverage, coverage_page(1));
  protocol.tell_surroundings(SurroundingsKind::coverage, coverage_page(2));
  v1::ServerMessage trajectories;
  (void)trajectories.mutable_trajectories();
  protocol.tell_surroundings(SurroundingsKind::trajectories,
                             std::make_shared<const std::string>(trajectories.SerializeAsString()));
  protocol.keyframes_durable(1);
  auto sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_TRUE(sent[0].has_keyframe_ack());
  sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_TRUE(sent[0].has_trajectories());
  sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].coverage().page().version(), 2U);
  EXPECT_TRUE(protocol.take_output().empty());
}

}  // namespace
}  // namespace headframe
