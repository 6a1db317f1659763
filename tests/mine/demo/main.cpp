// headframe-demo: three simulated robots map a mine; the real programs send, merge and export; we compare with the
// truth.

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "tests/mine/demo/before_after.hpp"
#include "tests/mine/demo/demo_mine.hpp"
#include "tests/mine/demo/http_get.hpp"
#include "tests/support/base_station.hpp"

namespace headframe::demo {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Replay {
  std::string robot;
  test::Process process;
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// One line that changes on a terminal, a line now and then elsewhere.
class ProgressLine {
 public:
  void show(const std::string& text) {
    if (terminal_) {
      std::printf("\r\033[K%s", text.c_str());
    } else if (seconds_since(shown_) > 5) {
      std::printf("%s\n", text.c_str());
      shown_ = Clock::now();
    }
    std::fflush(stdout);
  }
  void end(const std::string& text) {
    std::printf("%s%s\n", terminal_ ? "\r\033[K" : "", text.c_str());
    std::fflush(stdout);
  }

 private:
  bool terminal_ = isatty(STDOUT_FILENO) != 0;
  Clock::time_point shown_ = Clock::now();
};

std::string progress_text(double elapsed_s, const std::vector<RobotOutcome>& robots) {
  char text[64];
  std::snprintf(text, sizeof text, "%5.1f s ", elapsed_s);
  std::string line = text;
  for (const RobotOutcome& robot : robots) {
    std::snprintf(text, sizeof text, " | %s %llu keyframes, %.1f MB", robot.name.c_str(),
                  static_cast<unsigned long long>(robot.keyframes), static_cast<double>(robot.bytes_sent) / 1e6);
    line += text;
  }
  return line + " | " + std::to_string(count_together(robots)) + " of " + std::to_string(robots.size()) +
         " maps in one frame";
}

std::vector<RobotOutcome> ask(const test::BaseStation& station) {
  const auto sessions = http_get(station, "/api/v1/sessions", 5s);
  const auto atlas = http_get(station, "/api/v1/atlas", 5s);
  return outcome_of(sessions.value_or(nlohmann::json()), atlas.value_or(nlohmann::json()), {});
}

Result<void> watch(test::BaseStation& station, std::vector<Replay>& replays, Clock::time_point start) {
  ProgressLine line;
  for (bool running = true; running;) {
    while (station.process().read_line(0ms)) continue;  // so that the server never waits for us
    line.show(progress_text(seconds_since(start), ask(station)));
    running = false;
    for (Replay& replay : replays) {
      const int status = replay.process.poll();
      if (status > 0)
        return failure(ErrorCode::unavailable, "robot " + replay.robot + " failed with status " +
                                                   std::to_string(status) + "; see build/demo/" + replay.robot +
                                                   ".log");
      running = running || status < 0;
    }
    if (running) std::this_thread::sleep_for(200ms);
  }
  line.show("robots are home; the server finishes its merges");
  if (auto settled = http_get(station, "/api/v1/atlas?wait=60", 70s); !settled) return tl::unexpected(settled.error());
  line.end(progress_text(seconds_since(start), ask(station)));
  return {};
}

Result<std::vector<Replay>> start_robots(const test::BaseStation& station, const fs::path& dir) {
  std::vector<Replay> replays;
  for (const DemoRobot& robot : demo_robots()) {
    const auto admission = station.admission(robot.name);
    if (!admission) return tl::unexpected(admission.error());
    std::vector<std::string> argv{
        test::program("headframe-replay"), "--server", station.robots(), "--robot", robot.name, "--fast"};
    argv.insert(argv.end(), admission->begin(), admission->end());
    argv.push_back((dir / "mine" / robot.name).string());
    auto process = test::Process::start(argv, (dir / (robot.name + ".log")).string());
    if (!process) return tl::unexpected(process.error());
    replays.push_back({robot.name, std::move(*process)});
  }
  return replays;
}

Result<bool> run(const fs::path& dir) {
  const auto start = Clock::now();
  const fs::path recordings = dir / "mine", map = dir / "mine.ply", picture = dir / "before_after.png";
  auto made = prepare_recordings(recordings);
  if (!made) return tl::unexpected(made.error());
  std::printf("headframe demo: %s (%.1f s)\n",
              *made ? "a mine was dug and three robots drove through it" : "the recordings of an earlier run are used",
              seconds_since(start));
  std::error_code ignored;
  fs::remove_all(dir / "data", ignored);
  for (const DemoRobot& robot : demo_robots()) fs::remove(dir / ("data-" + robot.name + ".credential"), ignored);
  auto station = test::BaseStation::start(dir / "data");
  if (!station) return tl::unexpected(station.error());
  std::printf("headframe-server takes robots on %s, operator API on http://%s/\n", station->robots().c_str(),
              station->http().c_str());
  auto replays = start_robots(*station, dir);
  if (!replays) return tl::unexpected(replays.error());
  if (auto ok = watch(*station, *replays, Clock::now()); !ok) return tl::unexpected(ok.error());

  const auto sessions = http_get(*station, "/api/v1/sessions", 5s), atlas = http_get(*station, "/api/v1/atlas", 5s);
  if (!sessions) return tl::unexpected(sessions.error());
  if (!atlas) return tl::unexpected(atlas.error());
  const auto robots = outcome_of(*sessions, *atlas, recordings);
  std::printf("\n%s\n", table_of(robots).c_str());
  if (const auto component = largest_component(robots)) {
    const auto exported = station->command({"export", "--component", std::to_string(*component), map.string()});
    if (!exported || exported->status != 0)
      return failure(ErrorCode::unavailable,
                     "export failed: " + (exported ? exported->output : exported.error().message));
    std::printf("map      %s\n", map.c_str());
  }
  if (auto ok = draw_before_after(recordings, robots, picture); !ok) return tl::unexpected(ok.error());
  const bool right = merged_rightly(robots);
  std::printf("picture  %s\n%s (%.1f s)\n", picture.c_str(),
              right ? "merged rightly: one map, within 0.3 m and 1 deg of the truth"
                    : "NOT merged rightly: not one map within 0.3 m and 1 deg of the truth",
              seconds_since(start));
  return right;
}

}  // namespace
}  // namespace headframe::demo

int main(int argc, char** argv) {
  if (argc > 1) {
    std::fprintf(stderr, "headframe-demo: it takes no options, but was given '%s'\n", argv[1]);
    return 2;
  }
  try {
    const auto right = headframe::demo::run("build/demo");
    if (!right) std::fprintf(stderr, "\nheadframe-demo: %s\n", right.error().message.c_str());
    return right && *right ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "\nheadframe-demo: %s\n", error.what());
    return 1;
  }
}
