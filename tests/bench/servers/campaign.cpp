#include "tests/bench/servers/campaign.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <thread>

#include "server/cli/http_client.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/bench/servers/probe.hpp"
#include "tests/bench/servers/server_pair.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr const char* terminate_writer =
    "SELECT pg_terminate_backend(pid) FROM pg_locks WHERE locktype = 'advisory' AND granted";

/// Two servers, their database and their robots, from the first keyframe to the last.
class Block {
 public:
  Block(const ServersPlan& plan, test::PostgresCluster& cluster, fs::path scratch, const std::string& url,
        std::mt19937& random, ServersOutcome& outcome)
      : plan_(plan),
        cluster_(cluster),
        scratch_(std::move(scratch)),
        url_(url),
        random_(random),
        outcome_(outcome),
        servers_(scratch_, url) {
    for (int i = 0; i < plan.robots; ++i) names_.push_back("robot" + std::to_string(i));
    robots_.resize(names_.size());
  }

  Result<void> run(int kills) {
    keyframes_ = static_cast<std::uint64_t>(kills) * 30;
    auto done = servers_.start();
    if (done) done = follow_active();
    if (done) done = merge_drives();
    if (done) done = start_robots();
    if (!done) return done;
    RevisionWatch watch([this] { return http(); }, token_);
    for (const int last = outcome_.kills + kills; done && outcome_.kills < last;) done = round();
    const RevisionBook::Seen seen = watch.finish();
    outcome_.revisions.revisions += seen.revisions;
    outcome_.revisions.contradictions += seen.contradictions;
    if (outcome_.revisions.first.empty()) outcome_.revisions.first = seen.first;
    return done ? finish() : done;
  }

 private:
  int pick(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  std::string http() {
    const std::lock_guard lock(mutex_);
    return http_;
  }

  Result<void> follow_active() {
    const auto active = servers_.active();
    if (!active) return tl::unexpected(active.error());
    const std::lock_guard lock(mutex_);
    http_ = servers_.http(*active);
    return {};
  }

  Result<std::string> enrolled(const std::string& robot) { return enrolment(http_, servers_.data(), robot); }

  /// Three drives along one path, which become one component, so that there are revisions to make.
  Result<void> merge_drives() {
    std::ifstream(servers_.data() / "operator.token") >> token_;
    const std::map<std::string, test::Drive> drives{
        {"a", test::drive_a_to_c(2)}, {"b", test::drive_a_to_c(2.2)}, {"d", test::drive_a_to_c(2.4)}};
    for (const auto& [name, drive] : drives) {
      test::write_session(scratch_ / name, drive);
      const auto code = enrolled(name);
      if (!code) return tl::unexpected(code.error());
      auto replay = test::Process::start({test::program("headframe-replay"), "--server", servers_.robots(), "--robot",
                                          name, "--enrol", *code, "--spool", (scratch_ / "spools" / name).string(),
                                          "--fast", (scratch_ / name).string()});
      if (!replay) return tl::unexpected(replay.error());
      if (const auto ended = replay->wait(120s); !ended || ended->status != 0)
        return failure(ErrorCode::unavailable, "a drive: " + (ended ? ended->output : ended.error().message));
    }
    auto endpoint = parse_http_endpoint(http_);
    endpoint->token = token_;
    const auto atlas = HttpClient(*endpoint, {5, 400}).get("/api/v1/atlas?wait=300");
    if (!atlas) return tl::unexpected(atlas.error());
    const auto json = nlohmann::json::parse(atlas->body);
    if (json.at("components").size() != 1)
      return failure(ErrorCode::internal, "the drives did not become one component");
    return {};
  }

  Result<void> start_robots() {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      auto made = produce(names_[i], keyframes_, scratch_ / "oracle" / names_[i]);
      if (!made) return tl::unexpected(made.error());
      produced_[names_[i]] = std::move(*made);
      auto code = enrolled(names_[i]);
      if (!code) return tl::unexpected(code.error());
      enrolments_.push_back(std::move(*code));
      if (auto done = start_robot(i); !done) return done;
    }
    const auto code = enrolled(Probe::name);
    if (!code) return tl::unexpected(code.error());
    auto probe = Probe::start(scratch_ / "spools" / Probe::name, servers_.robots(), *code);
    if (!probe) return tl::unexpected(probe.error());
    probe_ = std::move(*probe);
    const auto first = probe_->acknowledged_after(Clock::now());
    return first ? Result<void>() : tl::unexpected(first.error());
  }

  Result<void> start_robot(std::size_t i) {
    auto started =
        test::Process::start({test::program("headframe-link-robot"), names_[i], spool(i).string(), servers_.robots(),
                              std::to_string(keyframes_), std::to_string(plan_.every_ms), enrolments_[i]});
    if (!started) return tl::unexpected(started.error());
    robots_[i].emplace(std::move(*started));
    return {};
  }

  Result<void> round() {
    std::this_thread::sleep_for(std::chrono::milliseconds(pick(5, 800)));
    const int kind = pick(0, 99);
    auto done = kind < 45   ? kill_active()
                : kind < 55 ? cut_off_active()
                : kind < 63 ? kill_standby()
                : kind < 75 ? kill_database(false)
                : kind < 80 ? kill_database(true)
                            : kill_robot();
    if (done) done = servers_.mend();
    if (done) done = follow_active();
    return done ? compare() : done;
  }

  Result<void> back(Clock::time_point begin, std::vector<double>& times_s) {
    const auto s = probe_->acknowledged_after(begin);
    if (!s) return tl::unexpected(s.error());
    times_s.push_back(*s);
    return {};
  }

  void kill(test::Process& process, int& count) {
    ++count;
    ++outcome_.kills;
    process.signal(SIGKILL);
    (void)process.wait(10s);
  }

  Result<void> kill_active() {
    const auto active = servers_.active();
    if (!active) return tl::unexpected(active.error());
    const auto begin = Clock::now();
    kill(servers_.server(*active).process, outcome_.active_kills);
    return back(begin, outcome_.failover_s);
  }

  Result<void> cut_off_active() {
    const auto active = servers_.active();
    if (!active) return tl::unexpected(active.error());
    const auto begin = Clock::now();
    ++outcome_.kills;
    ++outcome_.cuts;
    servers_.halt(*active);
    auto done = cluster_.execute(terminate_writer);
    if (done) done = back(begin, outcome_.cut_s);
    servers_.go_on(*active);
    if (!done) return done;
    const auto ended = servers_.server(*active).process.wait(30s);
    if (ended && ended->status == 1) return {};
    return failure(ErrorCode::internal, "a server that was cut off did not end with status 1: " +
                                            (ended ? std::to_string(ended->status) : ended.error().message));
  }

  Result<void> kill_standby() {
    const auto active = servers_.active();
    if (!active) return tl::unexpected(active.error());
    kill(servers_.server(1 - *active).process, outcome_.standby_kills);
    return {};
  }

  Result<void> kill_database(bool with_active) {
    const auto active = servers_.active();
    if (!active) return tl::unexpected(active.error());
    ++outcome_.kills;
    ++outcome_.database_kills;
    cluster_.kill();
    if (with_active) kill(servers_.server(*active).process, outcome_.active_kills);
    std::this_thread::sleep_for(std::chrono::milliseconds(pick(0, 1500)));
    if (auto started = cluster_.start(); !started) return started;
    return back(Clock::now(), outcome_.postgres_back_s);
  }

  Result<void> kill_robot() {
    const auto i = static_cast<std::size_t>(pick(0, plan_.robots - 1));
    kill(*robots_[i], outcome_.robot_kills);
    return start_robot(i);
  }

  /// What every robot, dead or halted for the moment, was told.
  Result<void> compare() {
    std::map<std::string, Told> all;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      auto one = told_so_far(names_[i], spool(i), *robots_[i], scratch_ / "copy");
      if (!one) return tl::unexpected(one.error());
      all[names_[i]] = std::move(*one);
    }
    const auto stored = outcome_.faults.keyframes, clouds = outcome_.faults.clouds;
    auto done = audited(all);
    outcome_.faults.keyframes = stored;  // counted once a block, by finish()
    outcome_.faults.clouds = clouds;
    return done;
  }

  Result<void> audited(const std::map<std::string, Told>& told) {
    const auto faults = audit({}, produced_, told, url_);
    if (!faults) return tl::unexpected(faults.error());
    ++outcome_.compares;
    outcome_.faults.add(*faults);
    return {};
  }

  /// All finish: every keyframe and cloud that was produced must be there.
  Result<void> finish() {
    const auto probed = probe_->finish();
    if (!probed) return tl::unexpected(probed.error());
    auto made = produce(Probe::name, *probed, scratch_ / "oracle" / Probe::name);
    if (!made) return tl::unexpected(made.error());
    produced_[Probe::name] = std::move(*made);
    for (auto& robot : robots_)
      if (const auto ended = robot->wait(240s); !ended || ended->status != 0)
        return failure(ErrorCode::unavailable,
                       "a robot did not finish: " + (ended ? ended->output : ended.error().message));
    std::map<std::string, Told> everything;
    for (const auto& [name, produced] : produced_) {
      Told& all = everything[name];
      all.keyframes = all.produced = produced.keyframes.size();
      for (std::uint64_t s = 1; s <= all.keyframes; ++s) all.clouds.insert(s);
    }
    return audited(everything);
  }

  fs::path spool(std::size_t i) const { return scratch_ / "spools" / names_[i]; }

  const ServersPlan plan_;
  test::PostgresCluster& cluster_;
  const fs::path scratch_;
  const std::string url_;
  std::mt19937& random_;
  ServersOutcome& outcome_;
  ServerPair servers_;
  std::uint64_t keyframes_ = 0;
  std::vector<std::string> names_, enrolments_;  // an enrolment may be shown again by the robot that used it
  std::map<std::string, Produced> produced_;
  std::string token_;
  std::mutex mutex_;  // of http_, which the watch reads
  std::string http_;
  std::vector<std::optional<test::Process>> robots_;
  std::unique_ptr<Probe> probe_;
};

}  // namespace

Result<ServersOutcome> servers_campaign(const ServersPlan& plan, test::PostgresCluster& cluster,
                                        const fs::path& scratch,
                                        const std::function<void(const ServersOutcome&)>& after_block) {
  ServersOutcome outcome;
  for (int block = 0; outcome.kills < plan.count; ++block) {
    std::seed_seq seed{plan.seed, static_cast<std::uint32_t>(block)};
    std::mt19937 random(seed);
    const auto url = cluster.make_database();
    if (!url) return tl::unexpected(url.error());
    const fs::path folder = scratch / ("block" + std::to_string(block));
    const int kills = std::min(plan.kills_a_block, plan.count - outcome.kills);
    auto done = Block(plan, cluster, folder, *url, random, outcome).run(kills);
    if (!done) return tl::unexpected(done.error());
    fs::remove_all(folder);
    if (after_block) after_block(outcome);
  }
  return outcome;
}

}  // namespace headframe::bench
