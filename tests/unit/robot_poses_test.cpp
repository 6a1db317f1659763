// Updates of poses as bytes: the server's side.
#include <functional>
#include <limits>

#include "common/wire/limits.hpp"
#include "common/wire/pose_message.hpp"
#include "tests/support/protocol_fixture.hpp"

namespace headframe {
namespace {

std::vector<KeyframePose> some_poses(std::uint64_t first, std::uint64_t last) {
  std::vector<KeyframePose> poses;
  for (std::uint64_t s = first; s <= last; ++s)
    poses.push_back({s, pose_from_yaw(0.01 * static_cast<double>(s), {static_cast<double>(s), 2, 3})});
  return poses;
}

v1::RobotMessage part(std::uint64_t number, std::size_t total, std::size_t offset,
                      const std::vector<KeyframePose>& poses) {
  v1::RobotMessage message;
  *message.mutable_pose_update() = to_proto(number, total, offset, poses);
  return message;
}

TEST_F(Protocol, AnUpdateOfPosesCountsWhenItIsWhole) {
  greet({100, {}});
  EXPECT_TRUE(feed(frame(part(3, 60, 0, some_poses(1, 40)))).empty());
  const auto events = feed(frame(part(3, 60, 40, some_poses(81, 100))));
  ASSERT_EQ(events.size(), 1U);
  const auto& update = std::get<PosesReceived>(events[0]);
  EXPECT_EQ(update.number, 3U);
  EXPECT_EQ(update.keyframes, 100U);
  ASSERT_EQ(update.poses.size(), 60U);
  EXPECT_EQ(update.poses[40].sequence, 81U);
  EXPECT_TRUE(update.poses[40].T_local_sensor.isApprox(some_poses(81, 81)[0].T_local_sensor));
  protocol.poses_durable(3);
  protocol.poses_durable(2);
  const auto said = messages(protocol.take_output());
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].pose_update_ack().durable_pose_update(), 3U) << "cumulative";
}

TEST_F(Protocol, AnUpdateThatBeginsAnewTakesThePlaceOfTheOneBefore) {
  greet({100, {}});
  EXPECT_TRUE(feed(frame(part(1, 60, 0, some_poses(1, 40)))).empty());
  const auto events = feed(frame(part(2, 1, 0, some_poses(7, 7))));
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<PosesReceived>(events[0]).poses.size(), 1U);
}

TEST_F(Protocol, TheWelcomeSaysWhichUpdateIsDurable) {
  ASSERT_EQ(feed(hello_frame()).size(), 1U);
  protocol.welcome({4, {}, 17});
  const auto said = messages(protocol.take_output());
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].welcome().durable_pose_update(), 17U);
}

TEST_F(Protocol, ASparesUpdateIsPassedOverAndWhatWasHalfThereToo) {
  greet({100, {}});
  EXPECT_TRUE(feed(frame(part(1, 60, 0, some_poses(1, 40)))).empty());
  protocol.stand_by();
  EXPECT_TRUE(feed(frame(part(1, 60, 40, some_poses(41, 60)))).empty());
  EXPECT_FALSE(protocol.ended());
}

TEST_F(Protocol, APoseOfAKeyframeThatDidNotComeIsOutOfOrder) {
  greet({100, {}});
  EXPECT_TRUE(feed(frame(part(1, 2, 0, some_poses(100, 101)))).empty());
  const auto said = error();
  EXPECT_EQ(said.kind(), v1::ERROR_KIND_OUT_OF_ORDER);
  EXPECT_FALSE(said.permanent());
}

TEST_F(Protocol, UpdatesThatAreNoneAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Spoil = std::function<void(v1::PoseUpdate&)>;
  const std::vector<Spoil> bad{[](auto& m) { m.set_number(0); },
                               [](auto& m) { m.set_number(std::numeric_limits<std::uint64_t>::max()); },
                               [](auto& m) { m.set_total_poses(0); },
                               [](auto& m) { m.set_total_poses(limits::update_poses + 1); },
                               [](auto& m) { m.set_total_poses(2); },
                               [](auto& m) { m.set_offset(1); },
                               [](auto& m) { m.set_offset(std::numeric_limits<std::uint32_t>::max()); },
                               [](auto& m) { m.clear_runs(); },
                               [](auto& m) { m.mutable_runs(0)->set_first(0); },
                               [](auto& m) { m.mutable_runs(0)->set_first(std::numeric_limits<std::uint64_t>::max()); },
                               [](auto& m) { *m.add_runs() = m.runs(0); },
                               [&](auto& m) { m.mutable_runs(0)->mutable_t_local_sensor(1)->set_x(nan); },
                               [](auto& m) { m.mutable_runs(0)->mutable_t_local_sensor(1)->set_y(1.1e8); },
                               [](auto& m) { m.mutable_runs(0)->mutable_t_local_sensor(1)->Clear(); },
                               [](auto& m) {
                                 for (std::size_t i = 0; i < limits::part_poses; ++i)
                                   *m.mutable_runs(0)->add_t_local_sensor() = m.runs(0).t_local_sensor(0);
                               }};
  for (const Spoil& spoil : bad) {
    auto message = part(1, 3, 0, some_poses(1, 3));
    spoil(*message.mutable_pose_update());
    RobotProtocol fresh{limits, now};
    fresh.receive(hello_frame(), now);
    ASSERT_TRUE(fresh.next());
    fresh.welcome({100000, {}});
    fresh.receive(frame(message), now);
    EXPECT_FALSE(fresh.next());
    EXPECT_TRUE(fresh.ended()) << message.ShortDebugString().substr(0, 200);
  }
  for (const auto& second : {part(1, 61, 40, some_poses(41, 60)), part(2, 60, 40, some_poses(41, 60)),
                             part(1, 60, 39, some_poses(41, 60)), part(1, 60, 40, some_poses(40, 59))}) {
    RobotProtocol fresh{limits, now};
    fresh.receive(hello_frame(), now);
    ASSERT_TRUE(fresh.next());
    fresh.welcome({100, {}});
    fresh.receive(frame(part(1, 60, 0, some_poses(1, 40))) + frame(second), now);
    EXPECT_FALSE(fresh.next());
    EXPECT_TRUE(fresh.ended()) << "it does not follow";
  }
}

}  // namespace
}  // namespace headframe
