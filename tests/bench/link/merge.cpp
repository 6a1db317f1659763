#include <cstdio>

#include "tests/bench/link/link.hpp"
#include "tests/mine/demo/demo_mine.hpp"
#include "tests/support/base_station.hpp"

namespace headframe::bench {
namespace {

using namespace std::chrono_literals;

/// The sessions of the server once both robots have come home and nothing is left to merge.
Result<nlohmann::json> merged_sessions(const std::filesystem::path& scratch) {
  if (auto made = demo::prepare_recordings(scratch / "mine"); !made) return tl::unexpected(made.error());
  auto station = test::BaseStation::start(scratch / "data");
  if (!station) return tl::unexpected(station.error());
  std::vector<test::Process> robots;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string& name = demo::demo_robots()[i].name;
    auto robot = station->replay(name, scratch / "mine" / name, {"--clouds", "on_request", "--linger", "45"});
    if (!robot) return tl::unexpected(robot.error());
    robots.push_back(std::move(*robot));
  }
  for (auto& robot : robots)
    if (const auto ended = robot.wait(300s); !ended || ended->status != 0)
      return failure(ErrorCode::unavailable, "a robot failed: " + (ended ? ended->output : ended.error().message));
  const auto atlas = station->settled_atlas();
  if (!atlas) return tl::unexpected(atlas.error());
  if (atlas->at("components").size() != 1) return failure(ErrorCode::unavailable, "the two robots were not merged");
  const auto sessions = station->command({"sessions", "--json"});
  if (!sessions) return tl::unexpected(sessions.error());
  return nlohmann::json::parse(sessions->output).at("sessions");
}

}  // namespace

nlohmann::json link_merge() {
  const test::ScratchFolder scratch;
  const auto sessions = merged_sessions(scratch.path());
  if (!sessions) return std::fprintf(stderr, "link merge: %s\n", sessions.error().message.c_str()), nlohmann::json();
  double bytes = 0, clouds = 0, keyframes = 0;
  for (const auto& row : *sessions) {
    bytes += row.at("bytes_received").get<double>();
    clouds += row.at("clouds").get<double>();
    keyframes += row.at("keyframes").get<double>();
  }
  std::printf("link merge: two robots of the demo, clouds on request\n  %.2f MB in all, %.0f of %.0f clouds\n",
              bytes / 1e6, clouds, keyframes);
  return {{"bytes_per_merge", bytes}, {"merge_clouds", clouds}, {"merge_keyframes", keyframes}};
}

}  // namespace headframe::bench
