#include "tests/bench/link/kills.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <optional>
#include <random>
#include <thread>

#include "tests/bench/link/enrol.hpp"
#include "tests/support/base_station.hpp"

namespace headframe::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// One base station and its robots, from the first keyframe to the last.
class Block {
 public:
  Block(const KillPlan& plan, fs::path scratch, std::mt19937& random)
      : plan_(plan), scratch_(std::move(scratch)), random_(random) {
    for (int i = 0; i < plan.robots; ++i) names_.push_back("robot" + std::to_string(i));
    robots_.resize(names_.size());
  }

  Result<void> run(int kills, KillOutcome& outcome) {
    for (const auto& name : names_) {
      auto made = produce(name, plan_.keyframes, scratch_ / "oracle" / name);
      if (!made) return tl::unexpected(made.error());
      produced_[name] = std::move(*made);
    }
    auto done = make_store();
    if (done) done = start_server();
    for (std::size_t i = 0; done && i < robots_.size(); ++i) done = start_robot(i);
    for (const int last = outcome.kills + kills; done && outcome.kills < last;) done = round(outcome);
    for (auto& robot : robots_) {
      if (!done) return done;
      const auto ended = robot->wait(180s);
      if (!ended || ended->status != 0)
        return failure(ErrorCode::unavailable,
                       "a robot did not finish: " + (ended ? ended->output : ended.error().message));
    }
    if (done) done = compare_all(outcome);
    return done;
  }

 private:
  int pick(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  Result<void> make_store() {
    if (!plan_.postgres) return {};
    auto made = plan_.postgres->make_database();
    if (!made) return tl::unexpected(made.error());
    url_ = *made;
    config_ = scratch_ / "config.toml";
    std::ofstream(config_) << "[store]\nurl = \"" << url_ << "\"\n";
    return {};
  }

  Result<void> start_server() {
    auto started = test::BaseStation::start(scratch_ / "data", listen_, false, config_);
    if (!started) return tl::unexpected(started.error());
    listen_ = started->robots();  // the same port from now on
    server_.emplace(std::move(*started));
    for (auto i = enrolments_.size(); i < names_.size(); ++i) {
      auto made = enrolment(server_->http(), scratch_ / "data", names_[i]);
      if (!made) return tl::unexpected(made.error());
      enrolments_.push_back(std::move(*made));
    }
    return {};
  }

  Result<void> start_robot(std::size_t i) {
    auto started =
        test::Process::start({test::program("headframe-link-robot"), names_[i], spool(i).string(), listen_,
                              std::to_string(plan_.keyframes), std::to_string(plan_.every_ms), enrolments_[i]});
    if (!started) return tl::unexpected(started.error());
    robots_[i].emplace(std::move(*started));
    return {};
  }

  // Robots are 0 and on.
  static constexpr int server_victim = -1, database_victim = -2;

  /// One robot, the server, or all; with PostgreSQL that too, as often as the server.
  std::vector<int> pick_victims() {
    std::vector<int> victims;
    const int kind = pick(0, 9), robots = static_cast<int>(robots_.size());
    const int one = kind >= 5 ? server_victim : kind % robots;
    for (int v = server_victim; v < robots; ++v)
      if (kind == 9 || v == one) victims.push_back(v);
    if (plan_.postgres && (kind == 9 || pick(0, 1) == 0)) victims = {database_victim};
    if (plan_.postgres && kind == 9) victims.push_back(server_victim);
    std::shuffle(victims.begin(), victims.end(), random_);
    return victims;
  }

  void kill(int victim, KillOutcome& outcome) {
    ++outcome.kills;
    outcome.server_kills += victim == server_victim ? 1 : 0;
    outcome.database_kills += victim == database_victim ? 1 : 0;
    if (victim == database_victim) return plan_.postgres->kill();
    auto& process = victim == server_victim ? server_->process() : *robots_[static_cast<std::size_t>(victim)];
    process.signal(SIGKILL);
    (void)process.wait(10s);
  }

  Result<void> start(int victim) {
    if (victim == database_victim) return plan_.postgres->start();
    return victim == server_victim ? start_server() : start_robot(static_cast<std::size_t>(victim));
  }

  Result<void> round(KillOutcome& outcome) {
    std::this_thread::sleep_for(std::chrono::milliseconds(pick(5, 400)));
    std::vector<int> victims = pick_victims();
    for (const int v : victims) kill(v, outcome);
    auto told = snapshot();
    std::shuffle(victims.begin(), victims.end(), random_);
    std::stable_partition(victims.begin(), victims.end(),
                          [](int v) { return v == database_victim; });  // it is waited for
    for (const int v : victims)
      if (auto done = start(v); !done) return done;
    if (!told) return tl::unexpected(told.error());
    return compare(*told, outcome);
  }

  /// What every robot, dead or halted for the moment, was told.
  Result<std::map<std::string, Told>> snapshot() {
    std::map<std::string, Told> all;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      auto one = told_so_far(names_[i], spool(i), *robots_[i], scratch_ / "copy");
      if (!one) return tl::unexpected(one.error());
      all[names_[i]] = std::move(*one);
    }
    return all;
  }

  Result<void> compare(const std::map<std::string, Told>& told, KillOutcome& outcome) {
    const auto faults = audit(scratch_ / "data", produced_, told, url_);
    if (!faults) return tl::unexpected(faults.error());
    ++outcome.compares;
    const auto stored = outcome.faults.keyframes, clouds = outcome.faults.clouds;
    outcome.faults.add(*faults);
    outcome.faults.keyframes = stored;  // counted once a block, by compare_all()
    outcome.faults.clouds = clouds;
    return {};
  }

  /// All have finished: every keyframe and cloud that was produced must be there.
  Result<void> compare_all(KillOutcome& outcome) {
    std::map<std::string, Told> everything;
    for (const auto& [name, produced] : produced_) {
      Told& all = everything[name];
      all.keyframes = all.produced = plan_.keyframes;
      for (std::uint64_t s = 1; s <= plan_.keyframes; ++s) all.clouds.insert(s);
    }
    const auto faults = audit(scratch_ / "data", produced_, everything, url_);
    if (!faults) return tl::unexpected(faults.error());
    ++outcome.compares;
    outcome.faults.add(*faults);
    return {};
  }

  fs::path spool(std::size_t i) const { return scratch_ / "spools" / names_[i]; }

  const KillPlan plan_;
  const fs::path scratch_;
  std::mt19937& random_;
  std::vector<std::string> names_, enrolments_;  // an enrolment may be shown again by the robot that used it
  std::map<std::string, Produced> produced_;
  std::string listen_ = "127.0.0.1:0";
  std::string url_;  // empty: SQLite
  fs::path config_;
  std::optional<test::BaseStation> server_;
  std::vector<std::optional<test::Process>> robots_;
};

}  // namespace

Result<KillOutcome> kill_campaign(const KillPlan& plan, const std::filesystem::path& scratch, KillOutcome outcome,
                                  const std::function<void(const KillOutcome&)>& after_block) {
  while (outcome.kills < plan.count) {
    std::seed_seq seed{plan.seed,
                       static_cast<std::uint32_t>(outcome.kills)};  // of this block, whoever ran those before
    std::mt19937 random(seed);
    const fs::path folder = scratch / ("block" + std::to_string(outcome.compares));
    const int kills = std::min(plan.kills_a_block, plan.count - outcome.kills);
    auto done = Block(plan, folder, random).run(kills, outcome);
    if (!done) return tl::unexpected(done.error());
    fs::remove_all(folder);
    if (after_block) after_block(outcome);
  }
  return outcome;
}

}  // namespace headframe::bench
