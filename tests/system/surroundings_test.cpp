// A robot is told what another one knows: over real sockets, from a real store, beside the truth of a drawn mine.
#include <gtest/gtest.h>

#include <condition_variable>
#include <thread>

#include "client/robot_client.hpp"
#include "server/map_merge_server.hpp"
#include "tests/support/branched_mine.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

/// The newest of what comes on the link's thread.
template <class Told>
class Newest {
 public:
  void set(const Told& told) {
    const std::lock_guard lock(mutex_);
    told_ = told;
    changed_.notify_all();
  }
  /// Waits until it is so; the test fails after five minutes.
  template <class Condition>
  Told wait_for(Condition condition) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, 300s, [&] { return told_ && condition(*told_); }));
    return told_.value_or(Told{});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Told> told_;
};

class TwoRobots : public testing::Test {
 protected:
  void SetUp() override {
    ServerConfig config;
    auto started = MapMergeServer::start({folder_.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, config, true});
    ASSERT_TRUE(started) << started.error().message;
    server_ = std::move(*started);
  }

  std::unique_ptr<RobotClient> robot(const std::string& name) const {
    RobotConfig config;
    config.robot = name;
    config.session = "s";
    config.spool = folder_.path() / name;
    config.host = server_->robots().host;
    config.port = server_->robots().port;
    config.insecure = true;
    auto opened = RobotClient::open(config);
    EXPECT_TRUE(opened);
    return opened ? std::move(*opened) : nullptr;
  }

  static void play(RobotClient& robot, const Drive& drive) {
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
      ASSERT_TRUE(robot.add_scan(static_cast<double>(i), drive.keyframes[i].T_local_sensor,
                                 drive.clouds[i].sweeps.front().points));
    const auto done = robot.finish(120s);
    ASSERT_TRUE(done) << done.error().message;
  }

  TempDir folder_;
  std::unique_ptr<MapMergeServer> server_;
};

TEST_F(TwoRobots, TheSecondGetsTheFirstsPathCoverageAndPointsInItsOwnFrame) {
  const Drive first_drive = drive_that_maps(), second_drive = drive(branched_mine(), {{108, 0}, {30, 0}}, -2, 9, 3);
  const auto first = robot("first");
  play(*first, first_drive);

  Newest<Trajectories> paths;
  Newest<Coverage> coverage;
  const auto second = robot("second");
  second->trajectories([&](const Trajectories& t) { paths.set(t); });
  second->coverage([&](const Coverage& c) { coverage.set(c); });
  EXPECT_NE(paths.wait_for([](const Trajectories&) { return true; }).missing, "") << "it is merged with nobody yet";
  play(*second, second_drive);

  // Truth: the second's local frame, seen from the mine.
  const Pose T_second_mine = second_drive.T_mine_local.inverse();
  const auto told = paths.wait_for([](const Trajectories& t) {
    return t.paths.size() == 1 && t.paths[0].p_local_m.size() > 30 && t.state == SurroundingsTold::State::told;
  });
  ASSERT_EQ(told.paths.size(), 1U);
  EXPECT_EQ(told.paths[0].session, (SessionKey{"first", "s"}));
  EXPECT_FALSE(told.paths[0].age_s) << "its stamps count from 0";
  for (const Eigen::Vector3d& p : told.paths[0].p_local_m) {
    double nearest_m = 1e9;
    for (const Keyframe& k : first_drive.keyframes)
      nearest_m = std::min(nearest_m, (T_second_mine * first_drive.T_mine_local * position(k) - p).norm());
    EXPECT_LT(nearest_m, 0.5);
  }

  const auto at = [&](const Coverage& c, double x, double y) { return c.at(T_second_mine * Eigen::Vector3d(x, y, 1)); };
  const auto seen =
      coverage.wait_for([&](const Coverage& c) { return at(c, 10, 0).what != 0 && at(c, 100, 0).what != 0; });
  EXPECT_TRUE(at(seen, 10, 0).what & coverage_path);
  EXPECT_EQ(seen.sessions.at(at(seen, 10, 0).session).robot, "first") << "the second was never there";
  EXPECT_TRUE(at(seen, 104, 4.5).what & coverage_free) << "the room, beside the path";
  EXPECT_FALSE(at(seen, 104, 4.5).what & coverage_path);
  EXPECT_EQ(at(seen, 10, 12).what, 0) << "rock";

  Newest<MapAround> map;
  const Eigen::Vector3d there(8, 0, 1);  // where the second never was
  second->map_around({SphereRegion{T_second_mine * there, 6}, 0.2}, [&](const MapAround& m) { map.set(m); });
  const MapAround points = map.wait_for([](const MapAround&) { return true; });
  EXPECT_EQ(points.refused, "");
  EXPECT_GT(points.points.size(), 300U);
  EXPECT_GT(points.clouds, 2U);
  std::size_t on_the_wall = 0;
  for (const Eigen::Vector3f& p : points.points) {
    const Eigen::Vector3d p_mine = second_drive.T_mine_local * (points.origin_local_m + p.cast<double>());
    EXPECT_LT((p_mine - there).norm(), 6.3);
    const double to_wall_m = std::min(
        {std::abs(std::abs(p_mine.y()) - 2), std::abs(p_mine.z()), std::abs(p_mine.z() - 3), std::abs(p_mine.x())});
    on_the_wall += to_wall_m < 0.3 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(on_the_wall), 0.9 * static_cast<double>(points.points.size()));

  // Only what came since: nothing has.
  Newest<MapAround> since;
  MapQuestion again{SphereRegion{T_second_mine * there, 6}, 0.2, points.held};
  second->map_around(again, [&](const MapAround& m) { since.set(m); });
  const MapAround nothing = since.wait_for([](const MapAround&) { return true; });
  EXPECT_TRUE(nothing.since);
  EXPECT_TRUE(nothing.points.empty());

  Newest<MapAround> refused;
  second->map_around({SphereRegion{there, 500}, 0.2}, [&](const MapAround& m) { refused.set(m); });
  EXPECT_NE(refused.wait_for([](const MapAround&) { return true; }).refused.find("200 m"), std::string::npos);
}

}  // namespace
}  // namespace headframe::test
