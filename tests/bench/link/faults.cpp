#include "tests/bench/link/faults.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

#include "server/map_merge_server.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/bench/link/seconds_since.hpp"

namespace headframe::bench {
namespace {

/// One robot as the bench watches it; times in seconds from the start.
struct Watched {
  std::string name;
  std::unique_ptr<RobotClient> client;
  std::vector<double> added_s, acknowledged_s;
};

void watch(Watched& robot, double now_s) {
  const auto acknowledged = std::min(robot.client->progress().keyframes_acknowledged, robot.added_s.size());
  while (robot.acknowledged_s.size() < acknowledged) robot.acknowledged_s.push_back(now_s);
}

/// Adds a keyframe a second to each robot and notes when it is acknowledged.
Result<void> drive(std::vector<Watched>& robots, double for_s) {
  const auto start = Clock::now();
  while (since(start) < for_s) {
    const double now_s = since(start);
    for (std::size_t i = 0; i < robots.size(); ++i) {
      auto& robot = robots[i];
      const double phase_s = static_cast<double>(i) / static_cast<double>(robots.size());
      if (now_s >= static_cast<double>(robot.added_s.size()) + phase_s) {
        robot.added_s.push_back(now_s);
        if (auto added = add_drive_keyframe(*robot.client, robot.name, robot.added_s.size()); !added)
          return tl::unexpected(added.error());
      }
      watch(robot, since(start));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  for (auto& robot : robots) watch(robot, for_s);
  return {};
}

void judge(const Watched& robot, const FaultPlan& plan, FaultOutcome& outcome) {
  const RadioConditions& radio = plan.radio;
  const auto light_s = radio.period_s - radio.blackout_s;
  for (std::size_t i = 0; i < robot.acknowledged_s.size(); ++i)
    if (radio.blackout_s <= 0 || std::fmod(robot.added_s[i], radio.period_s) < light_s - 5)
      outcome.lag_s.push_back(robot.acknowledged_s[i] - robot.added_s[i]);
  if (radio.blackout_s <= 0) return;
  for (double back_s = radio.period_s; back_s + 10 <= plan.seconds; back_s += radio.period_s) {
    const auto next = std::lower_bound(robot.acknowledged_s.begin(), robot.acknowledged_s.end(), back_s);
    outcome.recovery_s.push_back((next == robot.acknowledged_s.end() ? plan.seconds : *next) - back_s);
  }
}

}  // namespace

std::vector<RadioConditions> bad_radios() {
  RadioConditions loss, delay, thin, dark, together;
  loss.name = "20 % loss";
  together.loss = loss.loss = 0.2;
  delay.name = "1 s +- 500 ms";
  together.delay_s = delay.delay_s = 1;
  together.jitter_s = delay.jitter_s = 0.5;
  thin.name = "64 kbit/s";
  together.bytes_per_s = thin.bytes_per_s = 8000;
  dark.name = "30 s of 60 dark";
  together.blackout_s = dark.blackout_s = 30;
  together.name = "all together";
  return {loss, delay, thin, dark, together};
}

Result<FaultOutcome> drive_over(const FaultPlan& plan, const std::filesystem::path& scratch) {
  auto link = BadLink::make(plan.seed);
  if (!link) return tl::unexpected(link.error());
  ServerConfig config;
  config.merge.hypotheses = 1;  // the link is measured, not the merging of noise
  config.merge.least_path_m = 1e5;
  Result<std::unique_ptr<MapMergeServer>> server;
  (*link)->as_server([&] {
    server = MapMergeServer::start({scratch / "data", {BadLink::server_address, 0}, {"127.0.0.1", 0}, config});
  });
  if (!server) return tl::unexpected(server.error());
  std::vector<Watched> robots(static_cast<std::size_t>(plan.robots));
  for (std::size_t i = 0; i < robots.size(); ++i) {
    robots[i].name = "robot" + std::to_string(i);
    Result<std::string> enrolled;
    (*link)->as_server([&] { enrolled = enrolment(to_string((*server)->http()), scratch / "data", robots[i].name); });
    if (!enrolled) return tl::unexpected(enrolled.error());
    const auto robot = drive_config(robots[i].name, scratch / "spools" / robots[i].name, BadLink::server_address,
                                    (*server)->robots().port, *enrolled);
    Result<std::unique_ptr<RobotClient>> client;
    (*link)->as_robot([&] { client = RobotClient::open(robot); });
    if (!client) return tl::unexpected(client.error());
    robots[i].client = std::move(*client);
  }
  FaultOutcome outcome;
  (*link)->set(plan.radio);
  if (auto done = drive(robots, plan.seconds); !done) return tl::unexpected(done.error());
  outcome.bytes = (*link)->bytes_to_server();
  for (const auto& robot : robots) {
    outcome.clouds += robot.client->progress().clouds_acknowledged;
    judge(robot, plan, outcome);
  }
  (*link)->set({});
  std::map<std::string, Produced> produced;
  std::map<std::string, Told> everything;
  for (auto& robot : robots) {
    if (auto done = robot.client->finish(std::chrono::seconds(60)); !done) return tl::unexpected(done.error());
    auto made = produce(robot.name, robot.added_s.size(), scratch / "oracle" / robot.name);
    if (!made) return tl::unexpected(made.error());
    produced[robot.name] = std::move(*made);
    auto& all = everything[robot.name];
    all.keyframes = all.produced = robot.added_s.size();
    for (std::uint64_t s = 1; s <= all.keyframes; ++s) all.clouds.insert(s);
  }
  const auto faults = audit(scratch / "data", produced, everything);
  if (!faults) return tl::unexpected(faults.error());
  outcome.faults = *faults;
  return outcome;
}

void FaultOutcome::add(const FaultOutcome& other) {
  faults.add(other.faults);
  lag_s.insert(lag_s.end(), other.lag_s.begin(), other.lag_s.end());
  recovery_s.insert(recovery_s.end(), other.recovery_s.begin(), other.recovery_s.end());
  clouds += other.clouds;
  bytes += other.bytes;
}

}  // namespace headframe::bench
