// Real programs, real sockets, a real SQLite file: robots stream drawn drives, are killed, come back; the server too.

#include <gtest/gtest.h>

#include <csignal>
#include <functional>
#include <map>
#include <set>

#include "common/dataset/scan_file.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

class EndToEnd : public testing::Test {
 protected:
  void SetUp() override {
    write_session(folder("a"), drive_a_to_c(1));
    write_session(folder("b"), drive_b_to_a(1));
    write_session(folder("c"), drive_d_to_b(1));
  }

  std::filesystem::path folder(const std::string& name) const { return scratch.path() / name; }

  static Json sessions(const BaseStation& station) {
    const auto ended = station.command({"sessions", "--json"});
    EXPECT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
    return Json::parse(ended->output).at("sessions");
  }

  /// By robot: how many keyframes and clouds the server has.
  static std::map<std::string, std::pair<int, int>> counts(const BaseStation& station) {
    std::map<std::string, std::pair<int, int>> out;
    for (const auto& row : sessions(station)) {
      EXPECT_FALSE(out.contains(row.at("robot"))) << "one session a robot";
      out[row.at("robot")] = {row.at("keyframes"), row.at("clouds")};
    }
    return out;
  }

  /// Robot a at 20 times its speed, so that there is time to kill something.
  Result<Process> slowly(const BaseStation& station, const std::vector<std::string>& options) const {
    std::vector<std::string> argv{
        program("headframe-replay"), "--server", station.robots(), "--robot", "a", "--rate", "20"};
    const auto admission = station.admission("a");
    if (!admission) return tl::unexpected(admission.error());
    argv.insert(argv.end(), admission->begin(), admission->end());
    argv.insert(argv.end(), options.begin(), options.end());
    argv.push_back(folder("a").string());
    return Process::start(argv);
  }

  static void expect_done(Process& replay) {
    const auto ended = replay.wait(120s);
    ASSERT_TRUE(ended) << ended.error().message;
    EXPECT_EQ(ended->status, 0) << ended->output;
  }

  static std::size_t components(const BaseStation& station) {
    const auto atlas = station.settled_atlas();
    EXPECT_TRUE(atlas) << atlas.error().message;
    return atlas ? atlas->at("components").size() : 0;
  }

  /// Asks until it holds: nothing here waits for a time, only for a state.
  static bool until(const std::function<bool()>& holds) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    while (std::chrono::steady_clock::now() < deadline)
      if (holds()) return true;
    return false;
  }

  ScratchFolder scratch;
};

TEST_F(EndToEnd, ThreeRobotsBecomeOneComponentAndEachIsToldOfAll) {
  auto station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  auto a = station->replay("a", folder("a")), b = station->replay("b", folder("b"), {"--no-intensity"});
  expect_done(*a);
  expect_done(*b);
  EXPECT_EQ(components(*station), 1U);
  auto c = station->replay("c", folder("c"), {"--linger", "60"});  // connects later; it is told when it merges
  ASSERT_TRUE(c);
  std::string told;
  EXPECT_TRUE(until([&] {
    const auto line = c->read_line(60s);
    if (line) told = *line;
    return !line || (line->find("revision") != std::string::npos && line->find("a") != std::string::npos &&
                     line->find("b") != std::string::npos);
  })) << told;
  EXPECT_NE(told.find("revision"), std::string::npos) << told;
  EXPECT_EQ(components(*station), 1U);

  const auto ply = folder("map.ply"), tum = folder("a.txt");
  const std::string id = station->settled_atlas()->at("components")[0].at("id").dump();
  EXPECT_EQ(station->command({"export", "--component", id, ply.string()})->status, 0);
  EXPECT_GT(std::filesystem::file_size(ply), 100000U);
  const auto map = load_scan(ply);
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(std::set<float>(map->intensity.begin(), map->intensity.end()), (std::set<float>{0, 128}))
      << "what the scans of a and c say, and nothing of b";
  EXPECT_EQ(station->command({"trajectory", "a", tum.string()})->status, 0);
  EXPECT_GT(std::filesystem::file_size(tum), 500U);
}

TEST_F(EndToEnd, AServerKilledInTheMiddleLosesNothing) {
  auto station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  const std::string address = station->robots();
  auto a = slowly(*station, {});
  ASSERT_TRUE(a);
  int before = 0;
  for (int kills = 0; kills < 3; ++kills) {
    ASSERT_TRUE(until([&] { return counts(*station)["a"].first > before; }));
    before = counts(*station)["a"].first;
    station->process().signal(SIGKILL);
    ASSERT_TRUE(station->process().wait(10s));
    station = BaseStation::start(folder("data"), address);
    ASSERT_TRUE(station) << station.error().message;
    EXPECT_GE(counts(*station)["a"].first, before) << "acknowledged keyframes are still there";
  }
  expect_done(*a);
  const auto killed = counts(*station)["a"];

  auto calm = BaseStation::start(folder("calm"));
  auto again = calm->replay("a", folder("a"));
  expect_done(*again);
  EXPECT_EQ(counts(*calm)["a"], killed) << "the same as without any kill";
  EXPECT_EQ(killed.first, killed.second) << "every keyframe with its cloud";
}

TEST_F(EndToEnd, ARobotKilledInTheMiddleResumesItsSession) {
  auto station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  for (int kills = 0, before = 0; kills < 3; ++kills) {
    auto a = slowly(*station, {"--spool", folder("spool").string()});
    ASSERT_TRUE(a);
    ASSERT_TRUE(until([&] { return counts(*station)["a"].first > before; }));
    before = counts(*station)["a"].first;
    a->signal(SIGKILL);
    ASSERT_TRUE(a->wait(10s));
  }
  auto a = station->replay("a", folder("a"), {"--spool", folder("spool").string()});
  expect_done(*a);
  const auto resumed = counts(*station)["a"];
  const auto bytes = sessions(*station)[0].at("bytes_received").get<double>();

  auto calm = BaseStation::start(folder("calm"));
  auto again = calm->replay("a", folder("a"));
  expect_done(*again);
  EXPECT_EQ(counts(*calm)["a"], resumed);
  auto nothing_new = station->replay("a", folder("a"), {"--spool", folder("spool").string()});
  expect_done(*nothing_new);
  EXPECT_EQ(counts(*station)["a"], resumed);
  EXPECT_LT(sessions(*station)[0].at("bytes_received").get<double>() - bytes, 2000) << "nothing is sent twice";
}

TEST_F(EndToEnd, ARestartedServerHasItsAtlas) {
  auto station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  auto a = station->replay("a", folder("a")), b = station->replay("b", folder("b"));
  expect_done(*a);
  expect_done(*b);
  const auto before = station->settled_atlas();
  ASSERT_TRUE(before);
  EXPECT_GT(before->at("revision").get<int>(), 0);
  station->process().signal(SIGTERM);
  EXPECT_EQ(station->process().wait(30s)->status, 0);
  station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  const auto after = station->settled_atlas();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->at("revision"), before->at("revision"));
  EXPECT_EQ(after->at("components"), before->at("components"));
}

TEST_F(EndToEnd, OnRequestSendsOnlyTheCloudsThatAreAskedFor) {
  auto station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  const std::vector<std::string> on_request{"--clouds", "on_request", "--linger", "60"};
  auto a = station->replay("a", folder("a"), on_request), c = station->replay("c", folder("c"), on_request);
  auto b = station->replay("b", folder("b"), on_request);
  EXPECT_TRUE(until([&] {
    const auto ended = station->command({"atlas", "--json"});
    if (!ended || ended->status != 0) return false;
    const auto all = Json::parse(ended->output).at("components");
    return all.size() == 1 && all[0].at("sessions").size() == 3;
  }));
  int keyframes = 0, clouds = 0;
  for (const auto& [robot, count] : counts(*station)) {
    keyframes += count.first;
    clouds += count.second;
  }
  EXPECT_GT(clouds, 0);
  EXPECT_LT(clouds, keyframes);
}

TEST_F(EndToEnd, NeverSendsNoCloudAndNothingWaitsForIt) {
  auto station = BaseStation::start(folder("data"));
  ASSERT_TRUE(station) << station.error().message;
  auto a = station->replay("a", folder("a"), {"--clouds", "never"}),
       b = station->replay("b", folder("b"), {"--clouds", "never"});
  expect_done(*a);
  expect_done(*b);
  EXPECT_EQ(components(*station), 2U);
  EXPECT_EQ(counts(*station)["a"].second, 0);
}

}  // namespace
}  // namespace headframe::test
