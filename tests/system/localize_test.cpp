// Real programs, real sockets: a robot maps a mine, others wake up and ask where they are.

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "tests/support/base_station.hpp"
#include "tests/support/branched_mine.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

class Lost : public testing::Test {
 protected:
  void SetUp() override {
    auto started = BaseStation::start(scratch_.path() / "data");
    ASSERT_TRUE(started) << started.error().message;
    station_.emplace(std::move(*started));
    write_session(scratch_.path() / "mapper", drive_that_maps(1));
    auto mapper = station_->replay("mapper", scratch_.path() / "mapper");
    ASSERT_TRUE(mapper);
    const auto ended = mapper->wait(120s);
    ASSERT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
    ASSERT_TRUE(station_->settled_atlas());
  }

  /// Plays a drive, and reads what its robot prints until the first line that holds this; empty: it ended before.
  std::string first_line(const std::string& robot, const Drive& drive, const std::string& with,
                         const std::string& linger_s) {
    write_session(scratch_.path() / robot, drive);
    auto replay = station_->replay(robot, scratch_.path() / robot, {"--localize", "--linger", linger_s});
    EXPECT_TRUE(replay);
    while (const auto line = replay->read_line(120s)) {
      said_ += *line + "\n";
      if (line->find(with) != std::string::npos) return *line;
    }
    return "";
  }

  ScratchFolder scratch_;
  std::optional<BaseStation> station_;
  std::string said_;
};

TEST_F(Lost, ARobotThatWakesUpInTheMapIsToldWhereItIs) {
  const Drive woken = drive_that_wakes_up(1);
  const std::string line = first_line("woken", woken, "on the map of mapper/", "60");
  ASSERT_NE(line, "") << said_;
  double x = 0, y = 0, z = 0, yaw_deg = 0;
  unsigned long keyframe = 0;
  ASSERT_EQ(std::sscanf(line.c_str(), "where am I, keyframe %lu", &keyframe), 1) << line;
  const std::size_t at = line.find("T_component_sensor (");
  ASSERT_NE(at, std::string::npos) << line;
  ASSERT_EQ(std::sscanf(line.c_str() + at, "T_component_sensor (%lf, %lf, %lf) m, yaw %lf deg", &x, &y, &z, &yaw_deg),
            4)
      << line;
  // Somewhere on the way that it drove: which keyframes a robot makes is its own choice.
  const Pose T_map_mine = drive_that_maps(1).T_mine_local.inverse();
  double nearest_m = 1e9, turned_deg = 0;
  for (const Keyframe& k : woken.keyframes) {
    const Pose truth = T_map_mine * woken.T_mine_local * k.T_local_sensor;
    const double d = (truth.translation() - Eigen::Vector3d(x, y, z)).norm();
    if (d >= nearest_m) continue;
    nearest_m = d;
    turned_deg = std::remainder(yaw_rad(truth) * 180 / std::numbers::pi - yaw_deg, 360);
  }
  EXPECT_LT(nearest_m, 0.5) << line;
  EXPECT_LT(std::abs(turned_deg), 2) << line;
}

TEST_F(Lost, ARobotInRockThatNobodyMappedIsAnsweredAndNeverToldAPlace) {
  EXPECT_EQ(first_line("stranger", drive_elsewhere(1), "on the map of", "5"), "") << said_;
  EXPECT_NE(said_.find("where am I, keyframe"), std::string::npos) << said_;
  EXPECT_NE(said_.find("not yet"), std::string::npos) << said_;
}

}  // namespace
}  // namespace headframe::test
