// A robot that takes no bytes is closed at its deadline, and the others of its component do not notice.
#include <gtest/gtest.h>

#include <thread>

#include "server/net/robot_listener.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/support/nobodys_news.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

class StalledReader : public testing::Test {
 protected:
  static constexpr SessionId sessions = 700;  // their transforms fill most of a frame

  void SetUp() override {
    limits_.write_s = 0.5;
    store_ = open_sqlite_store(dir_.path()).value();
    atlas_.components.push_back({1, {}});
    for (SessionId id = 1; id <= sessions; ++id) {
      atlas_.components[0].placements.push_back({id, Pose::Identity()});
      store_->write(PutSession{session_record(id, name(id))}, [](const Result<void>& kept) { EXPECT_TRUE(kept); });
    }
    store_.reset();
    store_ = open_sqlite_store(dir_.path()).value();
    hub_.emplace(*store_, news_, limits_);
    ASSERT_TRUE(hub_->restore());
    listener_.emplace(io_, *hub_, Entrance{}, limits_);
    server_ = listener_->listen({"127.0.0.1", 0}).value();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~StalledReader() override {
    listener_->stop();
    thread_.join();
    store_.reset();  // its callbacks find the hub
  }

  static std::string name(SessionId id) { return std::string(100, 'r') + std::to_string(id); }

  /// Every robot of the component is told this revision.
  void publish(std::uint64_t revision) {
    atlas_.revision = revision;
    hub_->publish(atlas_, atlas_.components, {});
  }

  TempDir dir_;
  RobotLimits limits_;
  Atlas atlas_;
  std::unique_ptr<Store> store_;
  NobodysNews news_;
  std::optional<SessionHub> hub_;
  boost::asio::io_context io_;
  std::optional<RobotListener> listener_;
  Endpoint server_;
  std::thread thread_;
};

TEST_F(StalledReader, IsClosedAtItsDeadlineAndNobodyElseWaits) {
  RawRobot stalled(server_, 4096), well(server_);
  stalled.greet(robot_hello(name(1)));
  well.greet(robot_hello(name(2)));
  std::uint64_t revision = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (hub_->counts().stuck == 0 && std::chrono::steady_clock::now() < end) {
    publish(++revision);
    const auto told =
        well.read_until([&](const auto& m) { return m.has_error() || m.transform_update().revision() == revision; });
    ASSERT_TRUE(told && told->has_transform_update()) << "revision " << revision;
    EXPECT_EQ(told->transform_update().sessions_size(), static_cast<int>(sessions));
  }
  EXPECT_EQ(hub_->counts().stuck, 1U);
  well.send(keyframe_frame(line_keyframe(1)));
  EXPECT_TRUE(well.acknowledged(1));
  const auto rows = hub_->sessions();
  EXPECT_FALSE(rows[0].connected);
  EXPECT_TRUE(rows[1].connected);
  RawRobot again(server_);
  again.send(hello_frame(robot_hello(name(1))));
  const auto latest = again.read_until([](const auto& m) { return m.has_transform_update(); });
  ASSERT_TRUE(latest) << "it may come back, and is told the latest";
  EXPECT_EQ(latest->transform_update().revision(), revision);
}

}  // namespace
}  // namespace headframe
