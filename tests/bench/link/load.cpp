#include "tests/bench/link/load.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/bench/link/quantile.hpp"
#include "tests/bench/link/seconds_since.hpp"
#include "tests/bench/link/served.hpp"

namespace headframe::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

std::string config_of(const LoadPlan& plan) {
  std::ostringstream config;
  config << "[limits]\nrobots = " << plan.robots + 8 << "\n";
  if (!plan.store_url.empty()) config << "[store]\nurl = \"" << plan.store_url << "\"\n";
  if (plan.standby) config << "standby = true\n";
  if (plan.caches_mb > 0)
    for (const char* cache : {"[merge]\nclouds_mb", "places_mb", "walls_mb"})
      config << cache << " = " << plan.caches_mb << "\n";
  return config.str();
}

double rss_mb(int pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/statm");
  double pages = 0, resident = 0;
  in >> pages >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

struct Robot {
  std::string name;
  std::unique_ptr<RobotClient> client;
  std::vector<std::atomic<double>> added_s;  // by number - 1
  std::atomic<std::uint64_t> added{0};
  std::uint64_t acknowledged = 0;
  std::string error;
};

class Load {
 public:
  Load(const LoadPlan& plan, Served server, std::optional<Served> standby)
      : plan_(plan),
        server_(std::move(server)),
        standby_(std::move(standby)),
        robots_(static_cast<std::size_t>(plan.robots)) {}

  Result<void> connect(const fs::path& spools) {
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      auto& robot = robots_[i];
      robot.name = "robot" + std::to_string(i);
      robot.added_s = std::vector<std::atomic<double>>(static_cast<std::size_t>(plan_.seconds) + 2);
      const auto enrolled = enrolment(server_.http, server_.data, robot.name);
      if (!enrolled) return tl::unexpected(enrolled.error());
      auto config = drive_config(robot.name, spools / robot.name, "127.0.0.1", server_.port, *enrolled);
      config.sync = false;
      if (standby_ && plan_.relayed && i % 2 == 1)
        config.port = standby_->port;
      else if (standby_)
        config.more_servers.push_back({"127.0.0.1", standby_->port});
      auto client = RobotClient::open(config);
      if (!client) return tl::unexpected(client.error());
      robot.client = std::move(*client);
    }
    const auto connected = [](const Robot& robot) { return robot.client->progress().connected; };
    const auto start = Clock::now();
    while (!std::all_of(robots_.begin(), robots_.end(), connected)) {
      if (since(start) > 60) return failure(ErrorCode::unavailable, "not all robots could connect");
      std::this_thread::sleep_for(20ms);
    }
    return {};
  }

  LoadOutcome run() {
    outcome_.robots = plan_.robots;
    const double server_cpu_s = cpu_s(server_.process.pid()), own_cpu_s = cpu_s(::getpid());
    const double standby_cpu_s = standby_ ? cpu_s(standby_->process.pid()) : 0;
    start_ = Clock::now();
    std::thread driver([this] { drive(); });
    while (since(start_) < plan_.seconds + 2) {
      watch();
      std::this_thread::sleep_for(5ms);
    }
    driver.join();
    watch();
    outcome_.server_cores = (cpu_s(server_.process.pid()) - server_cpu_s) / since(start_);
    if (standby_) outcome_.standby_cores = (cpu_s(standby_->process.pid()) - standby_cpu_s) / since(start_);
    outcome_.robots_cores = (cpu_s(::getpid()) - own_cpu_s) / since(start_);
    for (auto& robot : robots_) {
      outcome_.keyframes += robot.added;
      outcome_.unacknowledged += robot.added - robot.acknowledged;
    }
    outcome_.ack_p50_ms = quantile(ack_ms_, 0.5);
    outcome_.ack_p99_ms = quantile(ack_ms_, 0.99);
    outcome_.ack_max_ms = quantile(ack_ms_, 1);
    const std::size_t settled = std::min<std::size_t>(rss_mb_.size() / 10 + 5, 60);
    if (rss_mb_.size() > settled) outcome_.rss_growth_mb = rss_mb_.back() - rss_mb_[settled];
    outcome_.rss_growth_half_mb = rss_mb_.back() - rss_mb_[rss_mb_.size() / 2];
    outcome_.rss_mb = rss_mb_.back();
    return outcome_;
  }

 private:
  /// A keyframe a second each, evenly spread over the second.
  void drive() {
    const auto robots = static_cast<double>(robots_.size());
    for (std::uint64_t number = 1; static_cast<double>(number) <= plan_.seconds; ++number)
      for (std::size_t i = 0; i < robots_.size(); ++i) {
        const double due_s = static_cast<double>(number - 1) + static_cast<double>(i) / robots;
        std::this_thread::sleep_until(
            start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(due_s)));
        const double now_s = since(start_);
        if (now_s > plan_.seconds) return;  // the bench itself can not keep up
        outcome_.late_ms = std::max(outcome_.late_ms, (now_s - due_s) * 1e3);
        auto& robot = robots_[i];
        robot.added_s[number - 1] = now_s;
        if (const auto added = add_drive_keyframe(*robot.client, robot.name, number, plan_.points); added && *added)
          robot.added = number;
      }
  }

  void watch() {
    for (auto& robot : robots_) {
      const Progress progress = robot.client->progress();
      const double now_s = since(start_);
      for (; robot.acknowledged < progress.keyframes_acknowledged; ++robot.acknowledged)
        if (const double added_s = robot.added_s[robot.acknowledged]; added_s > 5)
          ack_ms_.push_back((now_s - added_s) * 1e3);
      if (progress.link_error == robot.error) continue;
      robot.error = progress.link_error;
      if (robot.error.empty()) continue;
      ++outcome_.broken_links;
      if (outcome_.broken_why.empty()) outcome_.broken_why = robot.error;
    }
    if (since(start_) >= static_cast<double>(rss_mb_.size())) rss_mb_.push_back(rss_mb(server_.process.pid()));
  }

  const LoadPlan plan_;
  Served server_;
  std::optional<Served> standby_;
  std::vector<Robot> robots_;
  Clock::time_point start_;
  LoadOutcome outcome_;
  std::vector<double> ack_ms_;  // after the first five seconds
  std::vector<double> rss_mb_;  // once a second
};

}  // namespace

double cpu_s(int pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  std::string word;
  double user = 0, system = 0;
  for (int i = 1; i < 14; ++i) in >> word;
  in >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

Result<LoadOutcome> load(const LoadPlan& plan, const fs::path& scratch, const fs::path& spools) {
  const rlimit files{65536, 65536};
  (void)::setrlimit(RLIMIT_NOFILE, &files);
  auto server = serve(scratch, config_of(plan));
  if (!server) return tl::unexpected(server.error());
  std::optional<Served> standby;
  if (plan.standby) {
    if (auto known = make_known_as(*server, scratch / "standby"); !known) return tl::unexpected(known.error());
    auto waits = serve(scratch / "standby", config_of(plan));
    if (!waits) return tl::unexpected(waits.error());
    standby.emplace(std::move(*waits));
  }
  Load load(plan, std::move(*server), std::move(standby));
  if (auto done = load.connect(spools); !done) return tl::unexpected(done.error());
  return load.run();
}

}  // namespace headframe::bench
