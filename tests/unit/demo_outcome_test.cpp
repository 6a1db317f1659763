#include <gtest/gtest.h>

#include "tests/mine/demo/demo_mine.hpp"
#include "tests/mine/demo/outcome.hpp"

namespace headframe::demo {
namespace {

std::vector<RobotOutcome> robots(double error_m, double error_deg) {
  std::vector<RobotOutcome> all;
  for (const DemoRobot& robot : demo_robots()) {
    all.push_back({.name = robot.name, .sensor = robot.sensor});
    all.back().component = 7;
    all.back().error_m = error_m;
    all.back().error_deg = error_deg;
  }
  return all;
}

TEST(DemoOutcome, IsRightUpToTheLimitsAndNoFurther) {
  EXPECT_TRUE(merged_rightly(robots(0.299, 0.99)));
  EXPECT_FALSE(merged_rightly(robots(0.301, 0.99)));
  EXPECT_FALSE(merged_rightly(robots(0.299, 1.01)));
  EXPECT_FALSE(merged_rightly(robots(-1, -1)));  // nothing to judge by is not right
  EXPECT_FALSE(merged_rightly({}));
}

TEST(DemoOutcome, ARobotLeftOutIsNotRight) {
  auto all = robots(0.1, 0.1);
  all[2].component = 8;
  EXPECT_FALSE(merged_rightly(all));
  EXPECT_EQ(count_together(all), 2U);
  EXPECT_EQ(largest_component(all), 7U);
  all[0].component = 8;
  EXPECT_EQ(largest_component(all), 8U);
  all[1].component.reset();
  EXPECT_FALSE(merged_rightly(all));
}

TEST(DemoOutcome, AnswersThatLackEverythingAreDefaults) {
  for (const char* answer : {"null", "{}", "[]", R"({"components":[{"id":1}],"sessions":[{"robot":3}]})"}) {
    const auto json = nlohmann::json::parse(answer);
    const auto all = outcome_of(json, json, {});
    ASSERT_EQ(all.size(), demo_robots().size()) << answer;
    EXPECT_EQ(count_together(all), 0U) << answer;
    EXPECT_FALSE(merged_rightly(all)) << answer;
  }
}

TEST(DemoOutcome, ReadsWhatTheServerSays) {
  const std::string name = demo_robots()[1].name;
  const auto sessions = nlohmann::json{
      {"sessions", {{{"robot", name}, {"keyframes", 5}, {"bytes_received", 99}, {"trigger_to_transform_ms", 1500}}}}};
  const auto atlas = nlohmann::json{
      {"components",
       {{{"id", 4},
         {"sessions",
          {{{"robot", name}, {"T_component_session", {1, 0, 0, 8, 0, 1, 0, 9, 0, 0, 1, 10, 0, 0, 0, 1}}}}}}}}};
  const RobotOutcome robot = outcome_of(sessions, atlas, {})[1];
  EXPECT_EQ(robot.keyframes, 5U);
  EXPECT_EQ(robot.bytes_sent, 99U);
  EXPECT_EQ(robot.trigger_to_transform_ms, 1500);
  EXPECT_EQ(robot.component, 4U);
  EXPECT_EQ(robot.T_component_session.translation(), Eigen::Vector3d(8, 9, 10));
}

}  // namespace
}  // namespace headframe::demo
