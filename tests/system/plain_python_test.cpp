// The robot in plain Python with the real server, beside a robot of the C++ library.

#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <sstream>

#include "common/dataset/poses_file.hpp"
#include "common/dataset/text.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"
#include "tests/support/python_robot.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/truth.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

class PlainPython : public testing::Test {
 protected:
  void SetUp() override { begin(BaseStation::start(at("data"))); }
  void begin(Result<BaseStation> started) {
    ASSERT_TRUE(started) << started.error().message;
    station.emplace(std::move(*started));
  }

  std::filesystem::path at(const std::string& name) const { return scratch.path() / name; }

  Process python(const std::string& robot, const std::filesystem::path& session,
                 const std::vector<std::string>& options) {
    auto argv = python_robot();
    argv.insert(argv.end(), {"--server", station->robots(), "--robot", robot, "--credential", at(robot + ".credential"),
                             "--enrol", station->enrolment(robot).value()});
    argv.insert(argv.end(), options.begin(), options.end());
    argv.push_back(session.string());
    return Process::start(argv).value();
  }

  static std::string output_of(Process& process) {
    const auto ended = process.wait(300s);
    EXPECT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
    return ended ? ended->output : "";
  }

  /// "T_mine_ROBOT ..." as the client prints it.
  static std::optional<Pose> told(const std::string& output, const std::string& robot) {
    const auto line = output.find("T_mine_" + robot + " ");
    if (line == std::string::npos) return std::nullopt;
    std::istringstream numbers(output.substr(output.find(' ', line)));
    Pose T = Pose::Identity();
    for (int i = 0; i < 12; ++i) numbers >> T.matrix()(i / 4, i % 4);
    return T;
  }

  int keyframes() const {
    const auto ended = station->command({"sessions", "--json"});
    const auto rows = nlohmann::json::parse(ended->output).at("sessions");
    return rows.empty() ? 0 : rows[0].at("keyframes").get<int>();
  }

  ScratchFolder scratch;
  std::optional<BaseStation> station;
};

TEST_F(PlainPython, MergesByScanContextWithTheLibrarysRobotAndIsToldWhereItLies) {
  const Drive a = drive_a_to_b(1), b = drive_b_to_a(1);
  write_session(at("a"), a);
  write_session(at("b"), b);
  auto library =
      station->replay("a", at("a"), {"--family", "scan_context", "--clouds", "on_request", "--linger", "60"});
  ASSERT_TRUE(library);
  auto plain = python("b", at("b"), {"--linger", "120"});
  const auto T_b_a = told(output_of(plain), "a");
  ASSERT_TRUE(T_b_a) << "the robot in Python was not told of the other";
  const Pose error = (b.T_mine_local.inverse() * a.T_mine_local).inverse() * *T_b_a;
  EXPECT_LT(error.translation().norm(), 0.3);
  EXPECT_LT(rotation_angle_rad(error), 1.0 * M_PI / 180);
}

#ifdef HEADFRAME_NETWORKS
TEST_F(PlainPython, MergesOnARecordingWithTheLearnedDescriptor) {
  if (!std::filesystem::exists(recordings())) GTEST_SKIP() << "no recordings at " << recordings();
  const auto tunnel = recordings() / "tunnel-two";
  auto library = station->replay("r1", tunnel / "r1", {"--clouds", "on_request", "--linger", "60"});
  ASSERT_TRUE(library);
  auto plain = python("r2", tunnel / "r2",
                      {"--linger", "120", "--network", HEADFRAME_SOURCE_DIR "/common/descriptor/learned/learned.onnx"});
  const auto T_r2_r1 = told(output_of(plain), "r1");
  ASSERT_TRUE(T_r2_r1) << "the robot in Python was not told of the other";
  const auto error = overlap_error(read_true_path(tunnel, "r2"), read_true_path(tunnel, "r1"), *T_r2_r1);
  std::printf("tunnel-two r2 (Python) - r1: %.3f m, %.2f deg over %zu pairs\n", error.translation_m, error.rotation_deg,
              error.pairs);
  EXPECT_LT(error.translation_m, 0.3);
  EXPECT_LT(error.rotation_deg, 1);
}
#endif

/// A drive as odometry has it that climbs though the mine is level, and as SLAM knows at its end that it was.
class LoopsClosedAtTheEnd : public PlainPython {
 protected:
  void SetUp() override {
    PlainPython::SetUp();
    Drive climbs = drive_a_to_c(1);
    write_session(at("true"), climbs);
    for (std::size_t i = 0; i < climbs.keyframes.size(); ++i)
      climbs.keyframes[i].T_local_sensor.translation().z() += 0.03 * static_cast<double>(i);
    write_session(at("climbs"), climbs);
  }
  std::string corrected() const { return (at("true") / "poses.txt").string(); }

  /// Of each keyframe that the server has of the robot's session: how high it lies, by its stamp.
  std::map<double, double> heights(const std::string& robot) {
    (void)station->settled_atlas();
    const std::string file = at(robot + ".txt");
    const auto ended = station->command({"trajectory", robot, file});
    EXPECT_TRUE(ended && ended->status == 0) << ended->output;
    std::map<double, double> all;
    const auto poses = dataset::parse_poses(dataset::read_file(file, 1 << 20).value()).value();
    for (const auto& pose : poses) all[pose.stamp_s] = pose.T_local_sensor.translation().z();
    return all;
  }
  void expect_level(const std::string& robot) {
    const auto all = heights(robot);
    EXPECT_GT(all.size(), 10U);
    for (const auto& [stamp_s, z] : all) EXPECT_NEAR(z, 0, 0.002) << robot << ", at " << stamp_s << " s";
  }
};

TEST_F(LoopsClosedAtTheEnd, AreToldByTheRobotInPython) {
  auto closes = python("b", at("climbs"), {"--corrected", corrected()});
  EXPECT_NE(output_of(closes).find("keyframes were moved by"), std::string::npos);
  expect_level("b");
  auto same = python("a", at("true"), {"--corrected", corrected()});
  EXPECT_NE(output_of(same).find("0 keyframes were moved"), std::string::npos);
}

TEST_F(LoopsClosedAtTheEnd, AreToldByHeadframeReplayOnceAlsoWhenItIsStartedAgain) {
  for (const bool again : {false, true}) {
    auto replayed = station->replay("r", at("climbs"), {"--spool", at("spool"), "--corrected", corrected()});
    ASSERT_TRUE(replayed);
    const std::string said = output_of(*replayed);
    EXPECT_EQ(said.find("\n0 of ") != std::string::npos, again) << said;
    expect_level("r");
  }
  write_session(at("later"), drive_a_to_c(1), 1000);
  auto other = station->replay("s", at("later"), {"--corrected", corrected()});
  const auto ended = other->wait(300s);
  ASSERT_TRUE(ended);
  EXPECT_NE(ended->status, 0);
  EXPECT_NE(ended->output.find("no pose near the stamp of any keyframe"), std::string::npos) << ended->output;
}

TEST_F(PlainPython, AServerThatIsKilledCostsNothing) {
  write_session(at("a"), drive_a_to_c(1));
  auto plain = python("a", at("a"), {"--rate", "20", "--clouds", "all", "--cloud-form", "2"});
  for (int kills = 0, before = 0; kills < 2; ++kills) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    while (keyframes() <= before && std::chrono::steady_clock::now() < deadline) continue;
    before = keyframes();
    ASSERT_GT(before, 0);
    const std::string address = station->robots();
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
    begin(BaseStation::start(at("data"), address));
    EXPECT_GE(keyframes(), before) << "what was acknowledged is there";
  }
  const std::string said = output_of(plain);
  const auto row = nlohmann::json::parse(station->command({"sessions", "--json"})->output).at("sessions").at(0);
  EXPECT_EQ(said, row.at("keyframes").dump() + " keyframes, all acknowledged\n");
  EXPECT_EQ(row.at("keyframes"), row.at("clouds")) << "every keyframe with its cloud, in form 2";
}

TEST_F(PlainPython, WhatCanNotBeHelpedIsSaidInOneLine) {
  write_session(at("a"), drive_a_to_c(6));
  const auto said = [&](const std::vector<std::string>& options) {
    auto argv = python_robot();
    argv.insert(argv.end(), {"--server", station->robots(), "--robot", "a", "--patience", "1"});
    argv.insert(argv.end(), options.begin(), options.end());
    argv.push_back(at("a").string());
    const auto ended = Process::start(argv).value().wait(60s).value();
    EXPECT_NE(ended.status, 0);
    EXPECT_EQ(ended.output.find('\n'), ended.output.size() - 1) << ended.output;
    return ended.output;
  };
  const std::string credential = at("a.credential"), enrolment = station->enrolment("a").value();
  const std::string wrong_code = enrolment.substr(0, enrolment.size() - 32) + std::string(32, '0');
  const std::string wrong_server = "hf1-" + std::string(64, '0') + enrolment.substr(68);
  EXPECT_NE(said({"--credential", credential}).find("headframe robot add a"), std::string::npos);
  EXPECT_NE(said({"--credential", credential, "--enrol", "hf1-"}).find("no enrolment"), std::string::npos);
  EXPECT_NE(said({"--credential", credential, "--enrol", wrong_code}).find("the server says"), std::string::npos);
  EXPECT_NE(said({"--credential", at("b.credential"), "--enrol", wrong_server}).find(station->fingerprint()),
            std::string::npos);
  EXPECT_NE(said({"--insecure"}).find("TLS only"), std::string::npos);
}

}  // namespace
}  // namespace headframe::test
