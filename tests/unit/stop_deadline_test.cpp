#include "server/stop_deadline.hpp"

#include <gtest/gtest.h>

#include <future>

namespace headframe {
namespace {

TEST(StopDeadline, EndsAProcessThatHangsWhileItStops) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto hang = [](int status) {
    const StopDeadline deadline(std::chrono::milliseconds(10), status);
    std::promise<void> never;
    never.get_future().wait();
  };
  EXPECT_EXIT(hang(0), testing::ExitedWithCode(0), "not finished in time");
  EXPECT_EXIT(hang(1), testing::ExitedWithCode(1), "not finished in time");
}

TEST(StopDeadline, LeavesAloneWhatFinishesInTime) { const StopDeadline deadline(std::chrono::hours(1)); }

}  // namespace
}  // namespace headframe
