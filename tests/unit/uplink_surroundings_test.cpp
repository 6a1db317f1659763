// Questions about what others know, as bytes: the robot's side.
#include "common/wire/capabilities.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

v1::RobotMessage coverage_question() {
  v1::RobotMessage message;
  message.mutable_coverage_request()->set_epoch(9);
  return message;
}

TEST_F(UplinkProtocolTest, AServerThatDoesNotListItIsNotAskedAboutOthers) {
  start();
  (void)sent();
  welcome();
  EXPECT_FALSE(link_->ask_around(coverage_question()));
  EXPECT_EQ(sent(), Words{});
}

TEST_F(UplinkProtocolTest, AServerThatListsItIsAskedAndItsAnswersAreHandedOn) {
  start();
  (void)sent();
  v1::ServerMessage welcome;
  welcome.mutable_welcome()->set_protocol_version(protocol_version);
  welcome.mutable_welcome()->add_capabilities(std::string(surroundings_capability));
  hear(welcome);
  EXPECT_TRUE(link_->ask_around(coverage_question()));
  EXPECT_EQ(sent(), Words{"coverage?"});
  v1::ServerMessage page;
  page.mutable_coverage()->mutable_page()->set_version(7);
  hear(page);
  const auto* told = std::get_if<SurroundingsMessage>(&events_.back());
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->message->coverage().page().version(), 7U);
  link_->stand_by();
  const std::size_t before = events_.size();
  hear(page);
  EXPECT_EQ(events_.size(), before) << "a spare is told nothing";
}

}  // namespace
}  // namespace headframe
