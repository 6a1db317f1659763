// What the operator does through the real programs: anchor, label, survey and cloud requests, across kill -9.

#include <gtest/gtest.h>

#include <csignal>
#include <cstring>
#include <fstream>

#include "common/geometry/se3.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

Pose pose_of(const Json& sixteen) {
  Pose T;
  for (int i = 0; i < 16; ++i) T.matrix()(i / 4, i % 4) = sixteen.at(static_cast<std::size_t>(i)).get<double>();
  return T;
}

Pose pose_in(const Json& sessions, const std::string& robot) {
  for (const Json& placed : sessions)
    if (placed.at("robot") == robot) return pose_of(placed.at("T_component_session"));
  ADD_FAILURE() << robot << " is not in " << sessions.dump();
  return Pose::Identity();
}

/// Waits for the robot's line that tells of this revision, or a later one.
bool told_of(Process& robot, int revision) {
  while (const auto line = robot.read_line(60s)) {
    const auto at = line->find("revision ");
    if (at != std::string::npos && std::stoi(line->substr(at + 9)) >= revision) return true;
  }
  return false;
}

class OperatorActions : public testing::Test {
 protected:
  void SetUp() override {
    write_session(scratch.path() / "a", drive_a_to_c(1));
    write_session(scratch.path() / "b", drive_b_to_a(1));
    start();
  }
  void start() {
    auto started = BaseStation::start(scratch.path() / "data");
    ASSERT_TRUE(started) << started.error().message;
    station.emplace(std::move(*started));
  }
  void kill_and_restart() {
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
    start();
  }
  /// The command's JSON; it has to end well.
  Json json(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const auto ended = station->command(arguments);
    EXPECT_TRUE(ended && ended->status == 0) << arguments[0] << ": " << (ended ? ended->output : ended.error().message);
    return ended ? Json::parse(ended->output, nullptr, false) : Json();
  }
  std::string refused(const std::vector<std::string>& arguments) {
    const auto ended = station->command(arguments);
    EXPECT_TRUE(ended && ended->status == 1) << ended->output;
    return ended ? ended->output : "";
  }
  void replay(const std::string& robot) {
    auto process = station->replay(robot, scratch.path() / robot);
    ASSERT_TRUE(process && process->wait(120s)->status == 0);
    ASSERT_TRUE(station->settled_atlas());
  }
  Json only_component() {
    const auto atlas = station->settled_atlas();
    EXPECT_TRUE(atlas && atlas->at("components").size() == 1U) << atlas->dump();
    return atlas->at("components").at(0);
  }
  std::string contents(const std::string& file) const {
    std::ifstream in(scratch.path() / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string path(const std::string& file) const { return (scratch.path() / file).string(); }

  ScratchFolder scratch;
  std::optional<BaseStation> station;
};

/// b is chosen before it is merged with anything: the choice waits for the merge, and outlives kill -9.
TEST_F(OperatorActions, AnAnchorHoldsThroughARestartAndALaterMerge) {
  replay("b");
  EXPECT_EQ(json({"anchor", "b"}).at("component"), 1);
  kill_and_restart();
  auto a = station->replay("a", scratch.path() / "a", {"--linger", "120"});
  ASSERT_TRUE(a);
  ASSERT_TRUE(told_of(*a, 1)) << "the merge";
  Json component = only_component();
  EXPECT_EQ(component.at("anchor").at("robot"), "b");
  const Json first = component.at("sessions");
  EXPECT_TRUE(pose_in(first, "b").isApprox(Pose::Identity()));

  const int revision = json({"atlas"}).at("revision");
  const Json chosen = json({"anchor", "a"});
  EXPECT_EQ(chosen.at("revision"), revision + 1);
  EXPECT_TRUE(told_of(*a, revision + 1)) << "the robot hears of its new transform";
  component = only_component();
  EXPECT_EQ(component.at("anchor").at("robot"), "a");
  EXPECT_TRUE(pose_in(component.at("sessions"), "b").isApprox(pose_in(first, "a").inverse(), 1e-6));
  kill_and_restart();
  EXPECT_EQ(only_component(), component);
  EXPECT_NE(refused({"anchor", "c"}).find("there is no session \"c\"; there are"), std::string::npos);
}

TEST_F(OperatorActions, ALabelNamesASessionAndStays) {
  replay("a");
  EXPECT_EQ(json({"rename", "a", "north drift"}).at("label"), "north drift");
  kill_and_restart();
  EXPECT_EQ(json({"sessions"}).at("sessions").at(0).at("label"), "north drift");
  EXPECT_NE(station->command({"sessions"})->output.find("(north drift)"), std::string::npos);
  EXPECT_TRUE(json({"rename", "north drift", ""}).at("label").is_null()) << "it can be called by it";
  EXPECT_NE(refused({"rename", "a", std::string(129, 'x')}).find("at most 128 bytes"), std::string::npos);
}

TEST_F(OperatorActions, MissingCloudsComeFromALiveRobotWhenAskedFor) {
  auto a = station->replay("a", scratch.path() / "a", {"--clouds", "on_request", "--linger", "120"});
  ASSERT_TRUE(a);
  const auto row = [&] { return json({"sessions"}).at("sessions").at(0); };
  const auto wait_until = [&](const auto& condition) {
    for (int i = 0; i < 600; ++i)
      if (station->settled_atlas() && condition(row())) return true;
    return false;
  };
  ASSERT_TRUE(
      wait_until([](const Json& session) { return session.at("backlog") == 0 && session.at("complete") == true; }));
  ASSERT_EQ(row().at("clouds"), 0) << "nothing to merge with: none was asked for";
  const std::size_t keyframes = row().at("keyframes");
  EXPECT_EQ(json({"request-clouds", "a"}).at("requested"), keyframes);
  EXPECT_TRUE(wait_until([&](const Json& session) { return session.at("clouds") == keyframes; }));
  EXPECT_EQ(json({"request-clouds", "a"}).at("requested"), 0);
  a->signal(SIGKILL);
  ASSERT_TRUE(a->wait(10s));
  ASSERT_TRUE(wait_until([](const Json& session) { return session.at("connected") == false; }));
  EXPECT_NE(refused({"request-clouds", "a"}).find("away"), std::string::npos);
}

/// Control points that lie where session b truly is in a grid a million metres away; a's trajectory comes out there
/// too.
TEST_F(OperatorActions, ASurveyPutsExportsIntoTheGridAndStays) {
  replay("a");
  replay("b");
  const Pose T_grid_b = pose_from_yaw(-0.4, {1431250.5, 6212400.25, -300});
  std::ofstream csv(scratch.path() / "points.csv");
  csv.precision(12);
  csv << "name,xs,ys,zs,xg,yg,zg\n";
  for (const Eigen::Vector3d p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(40, 3, 0), Eigen::Vector3d(5, 20, 2)}) {
    const Eigen::Vector3d q = T_grid_b * p;
    csv << "P," << p.x() << ',' << p.y() << ',' << p.z() << ',' << q.x() << ',' << q.y() << ',' << q.z() << '\n';
  }
  csv.close();
  const Json set = json({"survey", "set", "b", path("points.csv")});
  EXPECT_LT(set.at("rms_m").get<double>(), 1e-5);
  kill_and_restart();
  const Json kept = json({"survey", "list"}).at("surveys").at(0);
  EXPECT_EQ(kept, set);
  const Json component = only_component();
  const std::string id = component.at("id").dump();
  const Json& placed = component.at("sessions");
  const Pose T_grid_a = T_grid_b * pose_in(placed, "b").inverse() * pose_in(placed, "a");
  json({"trajectory", "a", "--frame", "grid", path("a.txt")});
  std::istringstream tum(contents("a.txt"));
  std::string comment;
  std::getline(tum, comment);
  double stamp_s = 0, x = 0, y = 0, z = 0;
  tum >> stamp_s >> x >> y >> z;
  EXPECT_LT((Eigen::Vector3d(x, y, z) - T_grid_a.translation()).norm(), 0.01) << "a's first keyframe is its origin";
  json({"export", "--component", id, "--frame", "grid", path("map.ply")});
  const std::string ply = contents("map.ply");
  const std::size_t body = ply.find("end_header\n") + 11;
  ASSERT_GT(ply.size(), body + 27);
  Eigen::Vector3d p;
  std::memcpy(p.data(), ply.data() + body, sizeof(double) * 3);
  EXPECT_LT((p - T_grid_a.translation()).norm(), 100);
  json({"export", "--component", id, "--frame", "grid", path("plan.png")});
  EXPECT_EQ(contents("plan.png").substr(1, 3), "PNG");
  json({"survey", "drop", "b"});
  EXPECT_NE(refused({"export", "--component", id, "--frame", "grid", path("map2.ply")}).find("surveyed"),
            std::string::npos);
  std::ofstream(scratch.path() / "line.csv") << "A,0,0,0,0,0,0\nB,10,0,0,10,0,0\nC,20,0,0,20,0,0\n";
  EXPECT_NE(refused({"survey", "set", "b", path("line.csv")}).find("in a line"), std::string::npos);
  const Json overlay = json({"overlay", "1", "--most", "500"});
  EXPECT_GT(overlay.at("a").size(), 50U);
  EXPECT_GT(overlay.at("b").size(), 50U);
  std::uint64_t close = 0, all = 0;
  for (std::size_t i = 0; i < overlay.at("residuals_m").size(); ++i) {
    all += overlay.at("residuals_m")[i].get<std::uint64_t>();
    if (i < 5) close += overlay.at("residuals_m")[i].get<std::uint64_t>();
  }
  EXPECT_GT(close * 10, all * 8) << "within 10 cm: " << overlay.at("residuals_m").dump();
}

}  // namespace
}  // namespace headframe::test
