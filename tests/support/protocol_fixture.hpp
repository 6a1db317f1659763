#pragma once
// The server's side of the protocol with a manual clock.

#include <gtest/gtest.h>

#include "server/net/robot_protocol.hpp"
#include "tests/support/next_event.hpp"
#include "tests/support/robot_bytes.hpp"

namespace headframe {

class Protocol : public testing::Test {
 protected:
  std::vector<RobotEvent> feed(const std::string& bytes) {
    protocol.receive(bytes, now);
    std::vector<RobotEvent> events;
    while (auto event = next_event(protocol)) events.push_back(std::move(*event));
    return events;
  }

  void greet(const Durable& durable = {}) {
    ASSERT_EQ(feed(hello_frame()).size(), 1U);
    protocol.welcome(durable);
    ASSERT_TRUE(protocol.welcomed());
    (void)protocol.take_output();
  }

  void later(double s) {
    now += std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
    protocol.tick(now, true);
  }

  /// The error that was sent; the connection has to end with it.
  v1::ErrorReport error() {
    EXPECT_TRUE(protocol.ended());
    const auto sent = messages(protocol.take_output());
    return sent.empty() ? v1::ErrorReport() : sent.back().error();
  }

  RobotLimits limits;
  RobotProtocol::Time now{};
  RobotProtocol protocol{limits, now};
};

}  // namespace headframe
