// A robot whose SLAM closes a loop: over a real socket, into a real store, beside the truth of a drawn mine.
#include <gtest/gtest.h>

#include "client/robot_client.hpp"
#include "server/map_merge_server.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/support/branched_mine.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

class PoseUpdates : public testing::Test {
 protected:
  void serve() {
    auto started = MapMergeServer::start({folder_.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}, true});
    ASSERT_TRUE(started) << started.error().message;
    server_ = std::move(*started);
  }
  std::unique_ptr<RobotClient> robot() const {
    RobotConfig config;
    config.robot = "rover";
    config.session = "s";
    config.spool = folder_.path() / "spool";
    config.host = server_->robots().host;
    config.port = server_->robots().port;
    config.insecure = true;
    auto opened = RobotClient::open(config);
    EXPECT_TRUE(opened) << opened.error().message;
    return opened ? std::move(*opened) : nullptr;
  }
  /// Where keyframes lie by what the server has taken in, or holds until it does.
  std::vector<Pose> stored() const {
    const auto store = open_sqlite_store(folder_.path() / "data");
    EXPECT_TRUE(store) << store.error().message;
    std::vector<Pose> all;
    EXPECT_TRUE((*store)->each_keyframe(1, 1, [&](const Keyframe& k) { all.push_back(k.T_local_sensor); }));
    const auto waiting = (*store)->new_poses(1);
    for (const KeyframePose& pose : waiting->poses) all.at(pose.sequence - 1) = pose.T_local_sensor;
    return all;
  }

  TempDir folder_;
  std::unique_ptr<MapMergeServer> server_;
};

TEST_F(PoseUpdates, ReachTheStoreOfTheServerWhicheverOfTheTwoIsStartedAnew) {
  const Drive truth = drive_that_maps();
  std::vector<KeyframePose> closed;
  serve();
  {
    const auto first = robot();
    for (std::size_t i = 0; i < truth.keyframes.size(); ++i) {
      Pose drifted = truth.keyframes[i].T_local_sensor;
      drifted.translation().z() += 0.02 * static_cast<double>(i);
      const auto added = first->add_scan(static_cast<double>(i), drifted, truth.clouds[i].sweeps.front().points);
      ASSERT_TRUE(added) << added.error().message;
      if (*added) closed.push_back({first->last_keyframe(), truth.keyframes[i].T_local_sensor});
    }
    ASSERT_GT(closed.size(), 10U);
    server_.reset();  // it goes while the robot drives
    ASSERT_TRUE(first->update_poses(closed));
  }
  serve();
  {
    const auto second = robot();
    const auto done = second->finish(120s);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(second->progress().pose_updates_acknowledged, 1U);
  }
  for (const bool restarted : {false, true}) {
    if (restarted) serve();
    server_.reset();
    const std::vector<Pose> now = stored();
    ASSERT_EQ(now.size(), closed.size());
    for (std::size_t i = 0; i < now.size(); ++i)
      EXPECT_TRUE(now[i].isApprox(closed[i].T_local_sensor, 1e-9)) << i << (restarted ? " after a restart" : "");
  }
}

}  // namespace
}  // namespace headframe::test
