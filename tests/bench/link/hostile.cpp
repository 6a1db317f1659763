#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"
#include "server/map_merge_server.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/bench/link/faults.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/hostile_peers.hpp"

namespace headframe::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int robots = 10;
constexpr double every_s = 0.1;  // a keyframe and its cloud, of each robot

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Good {
  std::string name;
  std::unique_ptr<RobotClient> client;
  std::uint64_t added = 0;
  std::vector<double> added_s;
  std::size_t acknowledged = 0;
};

/// Keyframe to ack of all, in ms.
Result<std::vector<double>> drive(std::vector<Good>& good, double seconds) {
  std::vector<double> ack_ms;
  const auto start = Clock::now();
  for (auto& robot : good) {
    robot.added_s.clear();
    robot.acknowledged = 0;
  }
  for (bool all = false; since(start) < seconds || !all;) {
    all = true;
    for (auto& robot : good) {
      if (since(start) < seconds && since(start) >= static_cast<double>(robot.added_s.size()) * every_s) {
        robot.added_s.push_back(since(start));
        if (auto added = add_drive_keyframe(*robot.client, robot.name, ++robot.added); !added)
          return tl::unexpected(added.error());
      }
      const auto before = robot.added - robot.added_s.size();
      for (; before + robot.acknowledged < robot.client->progress().keyframes_acknowledged; ++robot.acknowledged)
        ack_ms.push_back((since(start) - robot.added_s[robot.acknowledged]) * 1e3);
      all = all && robot.acknowledged == robot.added_s.size();
    }
    if (since(start) > seconds + 60) return failure(ErrorCode::unavailable, "not all was acknowledged");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return ack_ms;
}

struct Measured {
  double calm_p99_ms = 0, hostile_p99_ms = 0;
  int attacks = 0;
};

Result<Measured> measure(double seconds, const std::filesystem::path& scratch) {
  ServerConfig config;
  config.limits.hello_s = 2;
  config.merge.least_path_m = 1e5;
  auto server = MapMergeServer::start({scratch / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, config});
  if (!server) return tl::unexpected(server.error());
  const std::string http = to_string((*server)->http());
  std::vector<Good> good(robots);
  for (std::size_t i = 0; i < good.size(); ++i) {
    good[i].name = "robot" + std::to_string(i);
    const auto code = enrolment(http, scratch / "data", good[i].name);
    if (!code) return tl::unexpected(code.error());
    auto client = RobotClient::open(
        drive_config(good[i].name, scratch / good[i].name, "127.0.0.1", (*server)->robots().port, *code));
    if (!client) return tl::unexpected(client.error());
    good[i].client = std::move(*client);
  }
  const auto code = enrolment(http, scratch / "data", "bad");
  if (!code) return tl::unexpected(code.error());
  const test::HostileTarget target{(*server)->robots(), "robot0", "bad", random_secret(token_bytes),
                                   parse_enrolment(*code)->code};
  test::enrol_accomplice(target);
  if (auto warm = drive(good, 2); !warm) return tl::unexpected(warm.error());
  const auto calm = drive(good, seconds);
  if (!calm) return tl::unexpected(calm.error());
  std::atomic<bool> stop{false};
  std::atomic<int> attacks{0};
  std::vector<std::thread> peers;
  peers.reserve(test::hostile_peers().size());
  for (const auto& peer : test::hostile_peers())
    peers.emplace_back([&] {
      while (!stop) {
        (void)peer.attack(target);
        ++attacks;
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
      }
    });
  const auto hostile = drive(good, seconds);
  stop = true;
  for (auto& peer : peers) peer.join();
  if (!hostile) return tl::unexpected(hostile.error());
  return Measured{quantile(*calm, 0.99), quantile(*hostile, 0.99), attacks};
}

}  // namespace

nlohmann::json link_hostile(double seconds) {
  const test::ScratchFolder scratch;
  const auto measured = measure(seconds, scratch.path());
  if (!measured) return std::fprintf(stderr, "link hostile: %s\n", measured.error().message.c_str()), nlohmann::json();
  const double ratio = measured->hostile_p99_ms / measured->calm_p99_ms;
  std::printf(
      "link hostile (%.0f s without and with; 10 robots, 10 keyframes a second each with their clouds)\n"
      "  keyframe to ack, p99: %.1f ms alone, %.1f ms beside %d attacks of eleven kinds: %.2f times\n",
      seconds, measured->calm_p99_ms, measured->hostile_p99_ms, measured->attacks, ratio);
  return {{"calm_p99_ms", measured->calm_p99_ms},
          {"hostile_p99_ms", measured->hostile_p99_ms},
          {"hostile_p99_ratio", ratio},
          {"hostile_attacks", measured->attacks}};
}

}  // namespace headframe::bench
