// Descriptor families through the real programs: a robot with a network of its user's, a server that holds none.

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

class Families : public testing::Test {
 protected:
  std::filesystem::path at(const std::string& name) const { return scratch.path() / name; }

  static std::string network(const std::string& name) {
    return "onnx:" HEADFRAME_SOURCE_DIR "/tests/data/networks/" + name + ".onnx";
  }

  Process::Ended replay(const BaseStation& station, const std::string& robot, const std::string& family,
                        const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options{"--family", family};
    options.insert(options.end(), more.begin(), more.end());
    auto process = station.replay(robot, at(robot), options);
    if (!process) return {-1, process.error().message};
    const auto ended = process->wait(120s);
    return ended ? *ended : Process::Ended{-1, ended.error().message};
  }

  ScratchFolder scratch;
};

TEST_F(Families, RobotsWithOneNetworkMergeOnAServerThatHasNoneAndWithOthersByTheWalls) {
  write_session(at("a"), drive_a_to_b(1));
  write_session(at("b"), drive_b_to_a(1));
  write_session(at("c"), drive_b_to_a(1));
  auto station = BaseStation::start(at("data"));
  ASSERT_TRUE(station) << station.error().message;
  for (const auto& [robot, family] :
       {std::pair{"a", network("without_w")}, {"b", network("without_w")}, {"c", std::string("lidar_iris")}}) {
    const auto ended = replay(*station, robot, family);
    EXPECT_EQ(ended.status, 0) << ended.output;
  }
  const auto atlas = station->settled_atlas();
  ASSERT_TRUE(atlas) << atlas.error().message;
  EXPECT_EQ(atlas->at("components").size(), 1U) << "a with b, and c by the walls";
  const auto listed = nlohmann::json::parse(station->command({"sessions", "--json"})->output);
  std::set<std::string> names;
  for (const auto& row : listed.at("sessions"))
    names.insert(row.at("family").at("name").get<std::string>().substr(0, 5));
  EXPECT_EQ(names, (std::set<std::string>{"lidar", "onnx-"}));
  const auto why = station->command({"explain", "a", "c"});
  ASSERT_TRUE(why);
  EXPECT_NE(why->output.find("are merged"), std::string::npos) << why->output;
}

TEST_F(Families, AFamilyThatIsOfNoUseIsSaidInOneLine) {
  write_session(at("a"), drive_a_to_c(6));
  auto station = BaseStation::start(at("data"));
  ASSERT_TRUE(station) << station.error().message;
  std::ofstream(at("text.onnx")) << "no network\n";
  std::ofstream(at("text.onnx.json"))
      << R"({"rows": 8, "columns": 64, "fov_up_deg": 20, "fov_down_deg": 20, "encoding": "range_m"})";
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"learnt", "no descriptor family 'learnt'; there are: learned, scan_context, lidar_iris, onnx:FILE"},
      {"", "no descriptor family ''"},
      {"onnx:" + at("none.onnx").string(), "none.onnx: no file that can be read"},
      {"onnx:" + at("text.onnx").string(), "text.onnx: no ONNX network, or one that was cut short"},
      {network("other_outputs"), "its outputs are features of 8, w of 64"}};
  for (const auto& [family, words] : wrong) {
    const auto ended = replay(*station, "a", family);
    EXPECT_EQ(ended.status, 1) << ended.output;
    EXPECT_EQ(ended.output.find("headframe-replay: "), 0U) << ended.output;
    EXPECT_NE(ended.output.find(words), std::string::npos) << ended.output;
    EXPECT_EQ(ended.output.find('\n'), ended.output.size() - 1) << "one line: " << ended.output;
  }
}

TEST_F(Families, ASpoolKeepsItsFamily) {
  write_session(at("a"), drive_a_to_c(6));
  auto station = BaseStation::start(at("data"));
  ASSERT_TRUE(station) << station.error().message;
  const std::vector<std::string> spool{"--spool", at("spool").string()};
  EXPECT_EQ(replay(*station, "a", "lidar_iris", spool).status, 0);
  const auto other = replay(*station, "a", "scan_context", spool);
  EXPECT_EQ(other.status, 1) << other.output;
  EXPECT_NE(other.output.find("family lidar_iris version 1 (80 + 72 values), not scan_context version 1"),
            std::string::npos)
      << other.output;
  EXPECT_EQ(replay(*station, "a", "lidar_iris", spool).status, 0);
}

}  // namespace
}  // namespace headframe::test
