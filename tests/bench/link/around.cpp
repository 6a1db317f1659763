#include <algorithm>
#include <atomic>
#include <cstdio>
#include <thread>

#include "client/robot_client.hpp"
#include "server/map_merge_server.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/bench/link/seconds_since.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/branched_mine.hpp"
#include "tests/support/faulty_proxy.hpp"

namespace headframe::bench {
namespace {

constexpr double thin_bytes_per_s = 8000;  // 64 kbit/s, each way

Result<std::unique_ptr<RobotClient>> robot(const std::string& name, const std::filesystem::path& folder,
                                           std::uint16_t port, double bytes_per_s) {
  RobotConfig config;
  config.robot = name;
  config.spool = folder / name;
  config.host = "127.0.0.1";
  config.port = port;
  config.insecure = true;
  config.bytes_per_s = bytes_per_s;
  config.keyframes.rotation_rad = 0.01;
  return RobotClient::open(config);
}

Result<void> play(RobotClient& robot, const test::Drive& drive) {
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
    if (auto added = robot.add_scan(static_cast<double>(i), drive.keyframes[i].T_local_sensor,
                                    drive.clouds[i].sweeps.front().points);
        !added)
      return tl::unexpected(added.error());
  return robot.finish(std::chrono::minutes(5));
}

/// Asks for everything around, again and again: the link is never without an answer on its way.
class Greedy {
 public:
  explicit Greedy(RobotClient& robot) : robot_(robot) {
    robot_.trajectories([](const Trajectories&) {});
    robot_.coverage([](const Coverage&) {});
    ask();
  }
  ~Greedy() {
    stopped_ = true;
    robot_.trajectories({});
    robot_.coverage({});
  }
  Greedy(const Greedy&) = delete;
  Greedy& operator=(const Greedy&) = delete;
  std::size_t points() const { return points_; }

 private:
  void ask() {
    robot_.map_around({SphereRegion{{20, 0, 0}, 30}, 0.1}, [this](const MapAround& map) {
      points_ += map.points.size();
      if (!stopped_) ask();
    });
  }
  RobotClient& robot_;
  std::atomic<bool> stopped_ = false;
  std::atomic<std::size_t> points_ = 0;
};

/// Adds a keyframe a second, and gives how long each took to be acknowledged.
Result<std::vector<double>> lags_s(RobotClient& robot, const Pose& T_last, double& stamp_s, double seconds) {
  std::vector<double> lags;
  for (double end_s = stamp_s + seconds; stamp_s < end_s; stamp_s += 1) {
    Points few;
    for (int i = 0; i < 300; ++i) few.emplace_back(2 + 0.01F * static_cast<float>(i), 1, 0.1F);
    constexpr double golden_angle_rad = 2.399963;  // it looks around, never twice the same way: a keyframe each time
    const Pose T = T_last * pose_from_yaw(golden_angle_rad * stamp_s, {0, 0, 0});
    const auto start = Clock::now();
    const auto added = robot.add_scan(stamp_s, T, few);
    if (!added) return tl::unexpected(added.error());
    while (*added && robot.progress().keyframes_acknowledged < robot.progress().keyframes && since(start) < 30)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (*added) lags.push_back(since(start));
    std::this_thread::sleep_until(start + std::chrono::seconds(1));
  }
  std::sort(lags.begin(), lags.end());
  return lags;
}

double at(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

Result<nlohmann::json> measured(double seconds) {
  const test::ScratchFolder scratch;
  const ServerOptions options{scratch.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}, true};
  auto server = MapMergeServer::start(options);
  if (!server) return tl::unexpected(server.error());
  const test::FaultyProxy thin((*server)->robots().port, {1, 0, 0, 0, thin_bytes_per_s});
  const auto first = robot("first", scratch.path(), (*server)->robots().port, 0);
  if (!first) return tl::unexpected(first.error());
  if (auto played = play(**first, test::drive_that_maps()); !played) return tl::unexpected(played.error());
  const auto second = robot("second", scratch.path(), thin.port(), thin_bytes_per_s);
  if (!second) return tl::unexpected(second.error());
  const test::Drive drive = test::drive(test::branched_mine(), {{108, 0}, {30, 0}}, -2, 9, 3);
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
    if (auto added = (*second)->add_scan(static_cast<double>(i), drive.keyframes[i].T_local_sensor,
                                         drive.clouds[i].sweeps.front().points);
        !added)
      return tl::unexpected(added.error());
  const auto start = Clock::now();
  while (since(start) < 300 && (!(*second)->transforms() || (*second)->progress().clouds_waiting > 0))
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  double stamp_s = 1000;
  const Pose& T_last = drive.keyframes.back().T_local_sensor;
  const auto alone = lags_s(**second, T_last, stamp_s, seconds);
  if (!alone) return tl::unexpected(alone.error());
  Greedy greedy(**second);
  const auto beside = lags_s(**second, T_last, stamp_s, seconds);
  if (!beside) return tl::unexpected(beside.error());
  std::printf(
      "a robot over 64 kbit/s, a keyframe and its cloud each second: keyframe to ack p50, p95, worst\n"
      "  alone %.0f, %.0f, %.0f ms of %zu; beside answers without a pause (%zu points of maps) %.0f, %.0f, "
      "%.0f ms of %zu\n",
      at(*alone, 0.5) * 1e3, at(*alone, 0.95) * 1e3, at(*alone, 1) * 1e3, alone->size(), greedy.points(),
      at(*beside, 0.5) * 1e3, at(*beside, 0.95) * 1e3, at(*beside, 1) * 1e3, beside->size());
  return nlohmann::json{{"around",
                         {{"alone_p50_s", at(*alone, 0.5)},
                          {"alone_p95_s", at(*alone, 0.95)},
                          {"beside_p50_s", at(*beside, 0.5)},
                          {"beside_p95_s", at(*beside, 0.95)}}}};
}

}  // namespace

nlohmann::json link_around(double seconds) {
  auto figures = measured(seconds);
  if (figures) return *figures;
  std::fprintf(stderr, "around: %s\n", figures.error().message.c_str());
  return nullptr;
}

}  // namespace headframe::bench
