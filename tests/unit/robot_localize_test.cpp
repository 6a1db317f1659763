// Robots that ask where they are: the server's side by bytes.
#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

TEST_F(Protocol, AQuestionWhereTheRobotIsComesAsItWasAsked) {
  greet();
  const auto events = feed(keyframe_frame(line_keyframe(1)) + localize_frame(false) + localize_frame(true));
  ASSERT_EQ(events.size(), 3U);
  EXPECT_TRUE(std::get<WhereAsked>(events[1]).asks);
  EXPECT_FALSE(std::get<WhereAsked>(events[2]).asks);
  EXPECT_TRUE(messages(protocol.take_output()).empty()) << "the answer is the merge worker's";
}

TEST_F(Protocol, AQuestionBeforeTheHelloIsOutOfOrder) {
  EXPECT_TRUE(feed(localize_frame(false)).empty());
  EXPECT_EQ(error().kind(), v1::ERROR_KIND_OUT_OF_ORDER);
}

TEST_F(Protocol, OfAnswersThatWaitTheNewestAloneIsSent) {
  greet();
  for (const std::uint64_t keyframe : {5U, 6U, 7U}) {
    v1::ServerMessage answer;
    answer.mutable_localization()->set_keyframe(keyframe);
    protocol.tell_localization(std::make_shared<const std::string>(answer.SerializeAsString()));
  }
  const auto sent = messages(protocol.take_output());
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].localization().keyframe(), 7U);
  EXPECT_TRUE(protocol.take_output().empty());
}

}  // namespace
}  // namespace headframe
