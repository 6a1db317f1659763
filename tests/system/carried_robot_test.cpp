// A robot that is carried from one mine into another while it drives, through the real programs and across kill -9:
// what it saw of each is merged with who else was there, and the two mines stay two.

#include <gtest/gtest.h>

#include <csignal>
#include <map>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

class CarriedRobot : public testing::Test {
 protected:
  void start() {
    auto started = BaseStation::start(file("data"), address);
    ASSERT_TRUE(started) << started.error().message;
    station.emplace(std::move(*started));
    address = station->robots();
  }
  void restart() {
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
    start();
  }
  std::string drive(const std::string& robot, const Drive& drive, const std::vector<std::string>& options = {}) {
    write_session(file(robot), drive);
    auto process = station->replay(robot, file(robot), options);
    const auto ended = process ? process->wait(120s) : tl::unexpected(process.error());
    EXPECT_TRUE(ended && ended->status == 0) << robot;
    return ended ? ended->output : "";
  }
  /// Keyframes by ROBOT/SESSION, or by the session's name where that is one of the robot's.
  std::map<std::string, int> keyframes() const {
    std::map<std::string, int> out;
    const auto listed = station->command({"sessions", "--json"});
    const Json all = Json::parse(listed->output);
    for (const Json& row : all.at("sessions"))
      out[row.at("robot").get<std::string>() + "/" + row.at("session").get<std::string>()] = row.at("keyframes");
    return out;
  }
  std::vector<std::set<std::string>> components() const {
    std::vector<std::set<std::string>> out;
    const Json atlas = *station->settled_atlas();
    for (const Json& component : atlas.at("components")) {
      auto& names = out.emplace_back();
      for (const Json& placed : component.at("sessions"))
        names.insert(placed.at("robot").get<std::string>() + "/" + placed.at("session").get<std::string>());
    }
    std::sort(out.begin(), out.end());
    return out;
  }
  std::filesystem::path file(const std::string& name) const { return scratch.path() / name; }

  ScratchFolder scratch;
  std::optional<BaseStation> station;
  std::string address = "127.0.0.1:0";
};

TEST_F(CarriedRobot, MergesInBothMinesAndJoinsThemNot) {
  start();
  drive("one", drive_b_to_a(3));
  drive("two", test::drive(other_mine(), {{78, 0}, {55, 0}, {55, 28}}, 0.7, 5));
  const Drive before = drive_a_to_c(3), after = test::drive(other_mine(), {{2, 0}, {78, 0}}, 0, 4);
  const int first = static_cast<int>(before.keyframes.size()), all = first + static_cast<int>(after.keyframes.size());
  const std::string said = drive("ant", carried(before, after, {400, 0, 0}), {"--linger", "20"});
  (void)components();  // the worker may be busy with what came before
  const auto counts = keyframes();
  std::string whole, part;
  for (const auto& [name, count] : counts)
    if (name.starts_with("ant/")) (name.find('~') == std::string::npos ? whole : part) = name;
  ASSERT_EQ(counts.size(), 4U);
  EXPECT_EQ(part, whole + "~" + std::to_string(first + 1));
  EXPECT_NE(said.find("on it is session " + part.substr(4) + ", which is merged for itself"), std::string::npos)
      << said;
  for (const bool killed : {false, true}) {
    if (killed) restart();
    EXPECT_EQ(keyframes().at(whole), first) << killed;
    EXPECT_EQ(keyframes().at(part), all - first) << killed;
    const auto listed = station->command({"sessions"});
    EXPECT_NE(listed->output.find(whole + ": from keyframe " + std::to_string(first + 1) + " on it is session "),
              std::string::npos)
        << listed->output;
    const auto merged = components();
    ASSERT_EQ(merged.size(), 2U) << killed;
    EXPECT_EQ(merged[0].size(), 2U);
    EXPECT_EQ(merged[1].size(), 2U);
    EXPECT_TRUE(merged[0].contains(whole) || merged[1].contains(whole));
    EXPECT_FALSE(merged[0].contains(whole) && merged[0].contains(part));
  }
}

}  // namespace
}  // namespace headframe::test
