#include "common/dataset/session_folder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "common/dataset/sensor_file.hpp"
#include "tests/support/scan_writers.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

/// A good session of three scans, to be spoiled by each test in its own way.
class SessionFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    dir_ = fs::temp_directory_path() / ("headframe_" + std::to_string(getpid()) + "_" + test->name());
    fs::create_directories(dir_ / "scans");
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(write_kitti(scan(k), {{static_cast<float>(k + 1), 2, 3}}));
    write(poses(), good_poses_);
    write(dir_ / "sensor.json",
          R"({"model":"m","beams":16,"fov_up_deg":15,"fov_down_deg":-25,"max_range_m":80,"x":1})");
  }
  void TearDown() override { fs::remove_all(dir_); }

  fs::path scan(int k) const { return dir_ / "scans" / ("00000" + std::to_string(k) + ".bin"); }
  fs::path poses() const { return dir_ / "poses.txt"; }

  // The folder is refused, with this code and these words.
  void expect_refused(ErrorCode code, const std::string& words) const {
    const auto folder = SessionFolder::open(dir_);
    ASSERT_FALSE(folder) << "expected: " << words;
    EXPECT_EQ(folder.error().code, code) << folder.error().message;
    EXPECT_NE(folder.error().message.find(words), std::string::npos)
        << folder.error().message << "\n  lacks: " << words;
    EXPECT_EQ(folder.error().message.find('\n'), std::string::npos) << "one line";
  }

  const std::string good_poses_ =
      "# t x y z qx qy qz qw\n\n0 0 0 0 0 0 0 1\n0.5 1 2 3 0 0 0.6 0.8\r\n 1.0\t2 0 0 0 0 0 -2\n";
  fs::path dir_;
};

TEST_F(SessionFolderTest, ReadsPosesSensorAndScans) {
  const auto folder = SessionFolder::open(dir_);
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->sensor().model, "m");
  EXPECT_EQ(folder->sensor().beams, 16);
  EXPECT_FLOAT_EQ(folder->sensor().fov_up_deg, 15);
  EXPECT_FLOAT_EQ(folder->sensor().fov_down_deg, 25) << "either sign means below the horizon";
  EXPECT_FLOAT_EQ(folder->sensor().max_range_m, 80);
  EXPECT_TRUE(folder->warnings().empty());
  ASSERT_EQ(folder->size(), 3U);
  EXPECT_DOUBLE_EQ(folder->stamp_s(1), 0.5);
  EXPECT_EQ(folder->T_local_sensor(1).translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(yaw_rad(folder->T_local_sensor(1)), 2 * std::atan2(0.6, 0.8), 1e-12);
  EXPECT_NEAR(rotation_angle_rad(folder->T_local_sensor(2)), 0, 1e-12) << "normalised";
  for (std::size_t k = 0; k < 3; ++k) {
    const auto scan = folder->load(k);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->points, (Points{{static_cast<float>(k + 1), 2, 3}}));
    EXPECT_EQ(scan->dropped, 0U);
  }
}

TEST_F(SessionFolderTest, WhatIsNotThereIsNamed) {
  fs::remove(poses());
  expect_refused(ErrorCode::not_found, "poses.txt: no such file");
  write(poses(), good_poses_);
  fs::remove_all(dir_ / "scans");
  expect_refused(ErrorCode::not_found, "scans: no such folder");
  fs::remove_all(dir_);
  expect_refused(ErrorCode::not_found, dir_.string() + ": no such folder");
}

TEST_F(SessionFolderTest, PosesMustBeOneAScan) {
  const std::string two = "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n";
  write(poses(), two);
  expect_refused(ErrorCode::bad_input, "2 poses in poses.txt but 3 scans");
  write(poses(), two + "2 0 0 0 0 0 0 1\n");
  EXPECT_TRUE(SessionFolder::open(dir_));
  write(poses(), two + "2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n");
  expect_refused(ErrorCode::bad_input, "4 poses in poses.txt but 3 scans");
  write(poses(), "# only words\n\n");
  expect_refused(ErrorCode::bad_input, "poses.txt: no poses");
}

TEST_F(SessionFolderTest, BadPosesAreNamedWithTheirLine) {
  const struct {
    const char* line;
    const char* words;
  } bad[] = {{"1 0 0 0 0 0 0 0", "line 3: the quaternion has length zero"},
             {"1 0 0 0 1e-7 0 0 0", "line 3: the quaternion has length zero"},
             {"1 0 nan 0 0 0 0 1", "line 3: 'nan' is no finite number"},
             {"1 0 0 0 0 0 inf 1", "line 3: 'inf'"},
             {"1 0 0 0 0 0 0 one", "line 3: 'one'"},
             {"1 0 0 0 0 0 0", "line 3: 7 values"},
             {"1 0 0 0 0 0 0 1 9", "line 3: 9 values"},
             {"0 0 0 0 0 0 0 1", "line 3: stamp 0 is not after"},
             {"-1 0 0 0 0 0 0 1", "line 3: stamp -1 is not after"}};
  for (const auto& [line, words] : bad) {
    write(poses(), std::string("# a comment\n0 0 0 0 0 0 0 1\n") + line + "\n2 0 0 0 0 0 0 1\n");
    expect_refused(ErrorCode::bad_input, words);
    expect_refused(ErrorCode::bad_input, poses().string());
  }
  write(poses(), "0 0 0 0 0 0 0 1\n1e-9 0 0 0 2e-6 0 0 0\n1 0 0 0 0 0 0 1\n");
  EXPECT_TRUE(SessionFolder::open(dir_)) << "just after, just long enough";
}

TEST_F(SessionFolderTest, ASensorThatIsNotToldIsTakenByDefaultWithAWarning) {
  fs::remove(dir_ / "sensor.json");
  auto folder = SessionFolder::open(dir_);
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->sensor().beams, dataset::default_sensor().beams);
  ASSERT_EQ(folder->warnings().size(), 1U);
  EXPECT_NE(folder->warnings()[0].find("sensor.json"), std::string::npos);
  write(dir_ / "sensor.json", R"({"beams": 64})");
  folder = SessionFolder::open(dir_);
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->sensor().beams, 64);
  EXPECT_EQ(folder->warnings().size(), 4U) << "model, both fields of view, range";
}

TEST_F(SessionFolderTest, ABadSensorIsRefused) {
  const struct {
    const char* json;
    const char* words;
  } bad[] = {{"{\"beams\": 3", "not JSON, at byte"},
             {"", "not JSON"},
             {"[1]", "not a JSON object"},
             {R"({"beams": "32"})", "'beams' is not a number"},
             {R"({"beams": 0})", "'beams' is 0, must be"},
             {R"({"beams": 1.5})", "whole number"},
             {R"({"model": 7})", "'model' is not a string"},
             {R"({"fov_up_deg": 91})", "'fov_up_deg' is 91"},
             {R"({"fov_down_deg": -91})", "'fov_down_deg' is -91"},
             {R"({"max_range_m": 1e999})", "sensor.json"},
             {R"({"max_range_m": 0})", "'max_range_m' is 0"}};
  for (const auto& [json, words] : bad) {
    write(dir_ / "sensor.json", json);
    expect_refused(ErrorCode::bad_input, words);
  }
}

TEST_F(SessionFolderTest, ScansAreOrderedByTheNumbersInTheirNames) {
  fs::remove_all(dir_ / "scans");
  fs::create_directories(dir_ / "scans");
  const char* names[] = {"s2.bin", "s10.ply", "s0010b.pcd"};
  ASSERT_TRUE(write_kitti(dir_ / "scans" / names[0], {{1, 2, 3}}));
  write(dir_ / "scans" / names[1], testing::ply({{2, 2, 3}}, "ascii"));
  write(dir_ / "scans" / names[2], testing::pcd({{3, 2, 3}}, "binary_compressed"));
  write(dir_ / "scans" / "notes.txt", "not a scan");
  const auto folder = SessionFolder::open(dir_);
  ASSERT_TRUE(folder) << folder.error().message;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto scan = folder->load(k);
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->points.size(), 1U);
    EXPECT_EQ(scan->points[0].x(), static_cast<float>(k + 1)) << names[k];
  }
  ASSERT_EQ(folder->warnings().size(), 1U);
  EXPECT_NE(folder->warnings()[0].find("passed over 1 files"), std::string::npos) << folder->warnings()[0];
}

TEST_F(SessionFolderTest, PointsThatAreNoneAreDroppedAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  ASSERT_TRUE(write_kitti(scan(0),
                          {{0, 0, 0},
                           {1, nan, 0},
                           {inf, 0, 0},
                           {0.009F, 0, 0},
                           {0.011F, 0, 0},
                           {0, -9999, 0},
                           {0, -10001, 0},
                           {1e30F, 0, 0}},
                          {1, 2, 3, 4, 5, 6, 7, 8}));
  const auto read = load_scan(scan(0));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->points, (Points{{0.011F, 0, 0}, {0, -9999, 0}}));
  EXPECT_EQ(read->intensity, (std::vector<float>{5, 6}));
  EXPECT_EQ(read->dropped, 6U);
}

TEST_F(SessionFolderTest, AnEmptyScanIsAScanAndATruncatedOneIsNot) {
  write(scan(0), "");
  const auto empty = load_scan(scan(0));
  ASSERT_TRUE(empty) << empty.error().message;
  EXPECT_TRUE(empty->points.empty());
  for (std::size_t bytes = 1; bytes < 32; ++bytes) {
    write(scan(0), std::string(bytes, 'x'));
    const auto read = load_scan(scan(0));
    EXPECT_EQ(read.has_value(), bytes == 16) << bytes;
    if (read) continue;
    EXPECT_EQ(read.error().message.find(scan(0).string() + ": truncated"), 0U) << read.error().message;
  }
}

TEST_F(SessionFolderTest, FilesThatCannotBeScansAreRefused) {
  EXPECT_EQ(load_scan(dir_ / "gone.bin").error().code, ErrorCode::not_found);
  EXPECT_EQ(load_scan(dir_ / "scan.las").error().code, ErrorCode::invalid_argument);
  fs::create_directories(dir_ / "folder.bin");
  EXPECT_EQ(load_scan(dir_ / "folder.bin").error().code, ErrorCode::bad_input);
  write(dir_ / "huge.bin", "");
  fs::resize_file(dir_ / "huge.bin", (std::uintmax_t{256} << 20) + 16);  // sparse
  EXPECT_EQ(load_scan(dir_ / "huge.bin").error().code, ErrorCode::bad_input);
  EXPECT_EQ(write_kitti(dir_ / "no_folder" / "a.bin", {}).error().code, ErrorCode::unavailable);
}

}  // namespace
}  // namespace headframe
