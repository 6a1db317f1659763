#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/dataset/session_folder.hpp"
#include "tests/mine/lattice.hpp"
#include "tests/mine/rock.hpp"
#include "tests/mine/session_folder.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe::mine {
namespace {

struct SmallMine {
  Plan plan;
  World world;
  Route route;
};

const SmallMine& small_mine() {
  static const SmallMine mine = [] {
    Plan plan = lattice_plan({.columns = 2, .rows = 2, .jitter_m = 2, .bend = 0.05}, Rng(3));
    Route route = route_through(plan, {0, 1, 3, 2}, 1, 50);
    if (route.size() < 40) route = route_through(plan, {1, 0, 2, 3}, 1, 50);
    return SmallMine{plan, build_world({plan}), route};
  }();
  return mine;
}

Robot small_robot(double drift) {
  Robot robot{.name = "r1", .lidar = *lidar_model("vlp16-hires")};
  robot.style.drift = drift;
  robot.style.frame_yaw_rad = 2;
  robot.style.tilt_sigma_rad = 0.05;
  robot.route = small_mine().route;
  return robot;
}

TEST(Drive, WithoutDriftTheBelievedPosesAreTheTrueOnes) {
  const Drive drive = drive_along(small_mine().route, small_robot(0).style, small_mine().world.caster, Rng(1));
  ASSERT_GT(drive.T_world_sensor.size(), 15U);
  for (std::size_t i = 0; i < drive.T_world_sensor.size(); ++i)
    EXPECT_LT((drive.T_world_local * drive.T_local_sensor[i]).matrix().cwiseAbs().sum() -
                  drive.T_world_sensor[i].matrix().cwiseAbs().sum(),
              1e-9);
  for (std::size_t i = 0; i < drive.T_world_sensor.size(); ++i)
    EXPECT_TRUE((drive.T_world_local * drive.T_local_sensor[i]).isApprox(drive.T_world_sensor[i], 1e-9));
}

TEST(Drive, DriftGrowsAndLeavesGravityAlone) {
  const Drive drive = drive_along(small_mine().route, small_robot(1).style, small_mine().world.caster, Rng(1));
  EXPECT_LT(drive.T_local_sensor.front().translation().norm(), 1e-12);
  const Pose T_end = drive.T_world_local * drive.T_local_sensor.back();
  EXPECT_GT((T_end.translation() - drive.T_world_sensor.back().translation()).norm(), 0.01);
  for (std::size_t i = 0; i < drive.T_world_sensor.size(); ++i)
    EXPECT_NEAR(tilt_rad(drive.T_local_sensor[i]), tilt_rad(drive.T_world_sensor[i]), 1e-9);
}

TEST(Drive, StaysInTheOpenAndNearlyUpright) {
  const Drive drive = drive_along(small_mine().route, small_robot(1).style, small_mine().world.caster, Rng(1));
  const Rock rock(small_mine().plan);
  double most_tilt_rad = 0;
  for (const Pose& T : drive.T_world_sensor) {
    EXPECT_LT(rock.depth_m(T.translation()), -0.3);
    most_tilt_rad = std::max(most_tilt_rad, tilt_rad(T));
  }
  EXPECT_LE(most_tilt_rad, 5.0 * std::numbers::pi / 180);
  EXPECT_GT(most_tilt_rad, 0.01);
}

TEST(SessionFolders, WhatIsWrittenIsReadBack) {
  const TempDir dir;
  const Recording recording = record(small_mine().world, small_robot(1), 7);
  const auto written = write_recordings(dir.path(), "small", "small mine", {recording});
  ASSERT_TRUE(written) << written.error().message;
  const auto folder = SessionFolder::open(dir.path() / "r1");
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_TRUE(folder->warnings().empty());
  EXPECT_EQ(folder->sensor().model, "vlp16-hires");
  EXPECT_FLOAT_EQ(folder->sensor().fov_down_deg, 10);
  ASSERT_EQ(folder->size(), recording.scans.size());
  for (const std::size_t i : {std::size_t{0}, folder->size() - 1}) {
    EXPECT_TRUE(folder->T_local_sensor(i).isApprox(recording.drive.T_local_sensor[i], 1e-5));
    const auto scan = folder->load(i);
    ASSERT_TRUE(scan);
    EXPECT_EQ(scan->points, recording.scans[i].points);
  }
  std::ifstream in(dir.path() / "truth.json");
  const auto truth = nlohmann::json::parse(in);
  EXPECT_NEAR(truth["robots"]["r1"]["frame_yaw_deg"], 2 * 180 / std::numbers::pi, 1e-6);
}

TEST(SessionFolders, AFolderThatCannotBeMadeIsAnError) {
  const TempDir dir;
  std::ofstream(dir.path() / "file") << "x";
  const auto written = write_recordings(dir.path() / "file" / "below", "t", "w", {});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::unavailable);
}

std::vector<Recording> recorded(const Request& request) {
  const auto scenario = make_scenario(request);
  EXPECT_TRUE(scenario) << (scenario ? "" : scenario.error().message);
  std::vector<Recording> recordings;
  if (scenario)
    for (const Robot& robot : scenario->robots) recordings.push_back(record(scenario->world, robot, request.seed));
  return recordings;
}

TEST(Scenario, TheSameRequestGivesTheSameScans) {
  const Request request{.kind = Kind::straight, .seed = 5, .overlap_pct = 40, .length_m = 40};
  const auto first = recorded(request), second = recorded(request);
  ASSERT_EQ(first.size(), 2U);
  for (std::size_t r = 0; r < 2; ++r) {
    ASSERT_EQ(first[r].scans.size(), second[r].scans.size());
    for (std::size_t i = 0; i < first[r].scans.size(); ++i)
      EXPECT_EQ(first[r].scans[i].points, second[r].scans[i].points);
  }
}

TEST(Scenario, LookAlikesShareNothing) {
  const auto r = recorded({.kind = Kind::look_alike, .seed = 2, .overlap_pct = 0, .length_m = 60});
  ASSERT_EQ(r.size(), 2U);
  EXPECT_GT(seen(r[0], 1, 1e9).size(), 1000U);
  EXPECT_EQ(overlap_pct(seen(r[0], 1, 1e9), seen(r[1], 1, 1e9)), 0);
}

TEST(Scenario, RequestedOverlapIsMetWithin12Percent) {
  for (const double wish_pct : {20.0, 45.0}) {
    const auto r = recorded({.kind = Kind::junctions, .seed = 11, .overlap_pct = wish_pct, .length_m = 80});
    ASSERT_EQ(r.size(), 2U);
    EXPECT_NEAR(overlap_pct(seen(r[0], 0.5, 1e9), seen(r[1], 0.5, 1e9)), wish_pct, 12);
  }
}

TEST(Scenario, BadRequestsAreRefusedInOneLine) {
  const auto message = [](const Request& request) {
    const auto scenario = make_scenario(request);
    return scenario ? std::string() : scenario.error().message;
  };
  EXPECT_NE(message({.sensors = {"sonar"}}).find("sonar"), std::string::npos);
  EXPECT_NE(message({.robots = 0}), "");
  EXPECT_NE(message({.overlap_pct = 95.1}), "");
  EXPECT_NE(message({.length_m = 9.9}), "");
  EXPECT_NE(message({.drift = std::nan("")}), "");
  EXPECT_EQ(message({.kind = Kind::straight, .robots = 1, .length_m = 10}), "");
}

TEST(Overlap, IsTheShareOfTheSmaller) {
  SeenVoxels few(1), many(1), none(1);
  few.add({{0.5F, 0.5F, 0.5F}, {-0.5F, 0.5F, 0.5F}}, Pose::Identity(), 10);
  many.add({{0.6F, 0.6F, 0.6F}, {3, 3, 3}, {5, 5, 5}, {50, 0, 0}}, Pose::Identity(), 10);
  EXPECT_EQ(many.size(), 3U);
  EXPECT_EQ(overlap_pct(few, many), 50);
  EXPECT_EQ(overlap_pct(many, few), 50);
  EXPECT_EQ(overlap_pct(none, many), 0);
}

}  // namespace
}  // namespace headframe::mine
