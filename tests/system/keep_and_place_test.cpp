// Clouds that go by themselves when room is short, and sessions that are laid on each other by hand, through the real
// programs and across kill -9.

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

class KeepAndPlace : public testing::Test {
 protected:
  void start(const std::string& config = "") {
    std::ofstream(file("hf.toml")) << config;
    auto started = BaseStation::start(file("data"), "127.0.0.1:0", false, file("hf.toml"));
    ASSERT_TRUE(started) << started.error().message;
    station.emplace(std::move(*started));
  }
  void restart(const std::string& config = "") {
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
    start(config);
  }
  void drive(const std::string& robot, const Drive& drive) {
    write_session(file(robot), drive);
    auto process = station->replay(robot, file(robot));
    ASSERT_TRUE(process && process->wait(120s)->status == 0);
  }
  std::filesystem::path file(const std::string& name) const { return scratch.path() / name; }
  Process::Ended run(const std::vector<std::string>& arguments) const {
    const auto ended = station->command(arguments);
    EXPECT_TRUE(ended);
    return ended.value_or(Process::Ended{-1, {}});
  }
  Json json(std::vector<std::string> arguments) const {
    arguments.emplace_back("--json");
    const auto ended = run(arguments);
    return Json::parse(ended.output, nullptr, false);
  }
  std::size_t components() const { return station->settled_atlas()->at("components").size(); }
  Json the_alignment() const { return json({"alignments"}).at("alignments").at(0); }

  ScratchFolder scratch;
  std::optional<BaseStation> station;
};

Pose pose_of(const Json& T) {
  Pose out;
  for (int i = 0; i < 16; ++i) out.matrix()(i / 4, i % 4) = T.at(static_cast<std::size_t>(i)).get<double>();
  return out;
}

/// Spots of the drive in both frames, seen a metre or two off.
void write_pairs(const std::filesystem::path& path, const Pose& T_a_b, const Drive& b) {
  std::ofstream out(path);
  out << "# in a, in b\n";
  const std::vector<Eigen::Vector3d> off{{1.5, 0, 0}, {0, -1.5, 0.5}, {-1, 1, 0}};
  for (std::size_t i = 0; i < off.size(); ++i) {
    const Eigen::Vector3d p_b = position(b.keyframes[i * (b.keyframes.size() - 1) / (off.size() - 1)]);
    out << (T_a_b * p_b + off[i]).transpose() << ' ' << p_b.transpose() << '\n';
  }
}

TEST_F(KeepAndPlace, WhatIsLaidOnEachOtherByHandWaitsForAConfirmationAcrossAKill) {
  start();
  const Drive a = drive_a_to_c(1), b = drive_b_to_a(1);
  drive("a", a);
  drive("b", b);
  ASSERT_EQ(components(), 1U);
  const Json merged = the_alignment();
  const Pose T_true = pose_of(merged.at("T_a_b"));
  const std::string id = merged.at("id").dump();
  write_pairs(file("spots.txt"), T_true, b);
  const std::vector<std::string> place{"place", "a", "b", "--pairs", file("spots.txt").string()};
  EXPECT_EQ(run(place).status, 1) << "they are merged: to be retracted first";
  ASSERT_EQ(run({"retract", id}).status, 0);
  const Eigen::Vector3d t = T_true.translation();
  const Json nowhere = json({"place", "a", "b", "--at", std::to_string(t.x()), std::to_string(t.y() + 14), "0", "171"});
  ASSERT_TRUE(nowhere.is_object());
  EXPECT_FALSE(nowhere.at("recorded"));
  EXPECT_TRUE(nowhere.at("moved_m").is_null()) << "nothing registered, so nothing was moved";
  const Json placed = json(place);
  ASSERT_TRUE(placed.is_object());
  EXPECT_TRUE(placed.at("recorded"));
  EXPECT_GT(placed.at("moved_m"), 0.1);
  EXPECT_FALSE(placed.at("explanation").at("findings").empty()) << "the evidence is shown";
  for (const bool killed : {false, true}) {
    if (killed) restart();
    const Json now = the_alignment();
    EXPECT_EQ(now.at("decision"), "placed") << killed;
    EXPECT_EQ(now.at("state"), "candidate");
    EXPECT_LT((T_true.inverse() * pose_of(now.at("T_a_b"))).translation().norm(), 0.3);
    EXPECT_EQ(components(), 2U) << "a hypothesis, until it is confirmed";
  }
  EXPECT_EQ(run({"confirm", id}).status, 0);
  EXPECT_EQ(components(), 1U);
  restart();
  EXPECT_EQ(components(), 1U);
  EXPECT_EQ(run({"undo", id}).status, 0);
  EXPECT_EQ(the_alignment().at("decision"), "placed");
}

TEST_F(KeepAndPlace, CoveredCloudsGoByThemselvesWhenRoomIsShort) {
  start();
  drive("a", drive_a_to_c(1));
  drive("c", drive_a_to_c(2));
  ASSERT_EQ(components(), 1U);
  const auto stored = [&] {
    std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> out;
    const Json all = json({"sessions"});
    for (const Json& session : all.at("sessions"))
      out[session.at("robot")] = {session.at("keyframes"), session.at("clouds")};
    return out;
  };
  const auto before = stored();
  const Json shown = json({"store", "show"});
  EXPECT_EQ(shown.at("keep"), "all");
  const std::uint64_t may_go = shown.at("may_go").at("clouds");
  ASSERT_GT(may_go, 10U) << "session c has driven where a did";
  restart("[limits]\ndatabase_mib = 100\n[store]\nkeep = 'newest'\nfree_mib = 100\n");
  std::uint64_t gone = 0;
  for (int i = 0; i < 300 && gone < may_go; ++i, std::this_thread::sleep_for(100ms))
    gone = json({"store", "show"}).at("let_go").get<std::uint64_t>();
  EXPECT_EQ(gone, may_go) << "what was shown before, and no more";
  const auto after = stored();
  EXPECT_EQ(after.at("a").first, before.at("a").first) << "keyframes stay";
  EXPECT_EQ(after.at("a").second, before.at("a").second - may_go);
  EXPECT_EQ(after.at("c"), before.at("c"));
  EXPECT_NE(run({"store", "show"}).output.find("keep        newest"), std::string::npos);
  drive("b", drive_b_to_a(1));
  EXPECT_EQ(components(), 1U) << "who comes later is merged with what stayed";
}

}  // namespace
}  // namespace headframe::test
