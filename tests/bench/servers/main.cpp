// ./run bench servers: two servers on one PostgreSQL under kills, and what that costs robots.
#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/bench/link/load.hpp"
#include "tests/bench/link/quantile.hpp"
#include "tests/bench/servers/campaign.hpp"
#include "tests/bench/servers/scaling.hpp"
#include "tests/support/base_station.hpp"

namespace headframe::bench {
namespace {

using Json = nlohmann::json;

/// New figures replace old ones of the same name; the others stay.
void save(const std::filesystem::path& path, const Json& figures) {
  Json all;
  if (std::ifstream in(path); in) all = Json::parse(in, nullptr, false);
  if (!all.is_object() || !all["servers"].is_object()) all = {{"servers", Json::object()}};
  all["servers"].update(figures);
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path) << all.dump(1) << "\n";
}

Json figures_of(const ServersOutcome& o, std::uint32_t seed) {
  const Faults& f = o.faults;
  return {{"seed", seed},
          {"kills", o.kills},
          {"active_kills", o.active_kills},
          {"cuts", o.cuts},
          {"standby_kills", o.standby_kills},
          {"database_kills", o.database_kills},
          {"robot_kills", o.robot_kills},
          {"lost", f.lost + f.clouds_lost},
          {"doubled", f.duplicated},
          {"corrupted", f.corrupted + f.clouds_corrupted},
          {"keyframes", f.keyframes},
          {"compares", o.compares},
          {"revisions", o.revisions.revisions},
          {"contradictions", o.revisions.contradictions},
          {"failover_p50_s", quantile(o.failover_s, 0.5)},
          {"failover_p95_s", quantile(o.failover_s, 0.95)},
          {"failover_max_s", quantile(o.failover_s, 1)},
          {"cut_p95_s", quantile(o.cut_s, 0.95)},
          {"postgres_back_p50_s", quantile(o.postgres_back_s, 0.5)},
          {"postgres_back_p95_s", quantile(o.postgres_back_s, 0.95)},
          {"postgres_back_max_s", quantile(o.postgres_back_s, 1)}};
}

void print(const ServersOutcome& o, std::uint32_t seed) {
  const Faults& f = o.faults;
  const auto n = [](std::uint64_t v) { return static_cast<unsigned long long>(v); };
  std::printf(
      "servers (seed %u)\n  %d kills: active %d, cut off %d, standby %d, PostgreSQL %d, robots %d; %d compares\n", seed,
      o.kills, o.active_kills, o.cuts, o.standby_kills, o.database_kills, o.robot_kills, o.compares);
  std::printf("  of %llu keyframes lost %llu, doubled %llu, corrupted %llu %s\n", n(f.keyframes),
              n(f.lost + f.clouds_lost), n(f.duplicated), n(f.corrupted + f.clouds_corrupted), f.first.c_str());
  std::printf("  of %llu revisions %llu contradict others %s\n", n(o.revisions.revisions),
              n(o.revisions.contradictions), o.revisions.first.c_str());
  const auto row = [](const char* what, const std::vector<double>& s) {
    std::printf("  %-52s p50 %5.2f  p95 %5.2f  max %5.2f s (%zu)\n", what, quantile(s, 0.5), quantile(s, 0.95),
                quantile(s, 1), s.size());
  };
  row("active server killed to a new keyframe acknowledged", o.failover_s);
  row("active server halted and cut off, the same", o.cut_s);
  row("PostgreSQL back to a new keyframe acknowledged", o.postgres_back_s);
  std::fflush(stdout);
}

bool bench_kills(const ServersPlan& plan, const std::filesystem::path& out) {
  const auto cluster = test::PostgresCluster::make();
  if (!cluster) return std::fprintf(stderr, "servers: %s\n", cluster.error().message.c_str()), false;
  const test::ScratchFolder scratch;
  const auto outcome = servers_campaign(plan, **cluster, scratch.path(), [&](const ServersOutcome& so_far) {
    save(out, figures_of(so_far, plan.seed));
    std::fprintf(stderr, "servers: %d kills of %d\n", so_far.kills, plan.count);
  });
  if (!outcome) return std::fprintf(stderr, "servers: %s\n", outcome.error().message.c_str()), false;
  print(*outcome, plan.seed);
  return outcome->faults.sum() == 0 && outcome->revisions.contradictions == 0;
}

struct AckRun {
  const char* name;
  const char* key;  // of its figures
  bool postgres, standby, relayed;
};
constexpr std::array<AckRun, 4> ack_runs{{{"SQLite", "sqlite_", false, false, false},
                                          {"PostgreSQL", "postgresql_", true, false, false},
                                          {"PostgreSQL, a server stands by", "", true, true, false},
                                          {"... and relays half of the robots", "relayed_", true, true, true}}};

/// Over SQLite, over PostgreSQL, and over that beside a server that stands by; all on the same disk.
bool bench_acks(LoadPlan plan, const std::filesystem::path& out) {
  const auto cluster = test::PostgresCluster::make(std::filesystem::temp_directory_path());
  if (!cluster) return std::fprintf(stderr, "servers: %s\n", cluster.error().message.c_str()), false;
  std::printf("acks (%d robots, a keyframe and its cloud a second each, %.0f s)\n", plan.robots, plan.seconds);
  Json figures;
  for (const AckRun& run : ack_runs) {
    plan.standby = run.standby;
    plan.relayed = run.relayed;
    const auto url = run.postgres ? (*cluster)->make_database() : Result<std::string>("");
    if (!url) return std::fprintf(stderr, "servers: %s\n", url.error().message.c_str()), false;
    plan.store_url = *url;
    const test::ScratchFolder scratch;
    const auto o = load(plan, scratch.path(), scratch.path() / "robots");  // whose spools are not synced
    if (!o) return std::fprintf(stderr, "servers: %s\n", o.error().message.c_str()), false;
    std::printf(
        "  %-34s p50 %6.1f  p99 %6.1f  max %6.1f ms, %llu of %llu not acknowledged after two seconds; cores: "
        "active %.2f, standby %.2f\n",
        run.name, o->ack_p50_ms, o->ack_p99_ms, o->ack_max_ms, static_cast<unsigned long long>(o->unacknowledged),
        static_cast<unsigned long long>(o->keyframes), o->server_cores, o->standby_cores);
    std::fflush(stdout);
    figures[std::string(run.key) + "ack_p50_ms"] = o->ack_p50_ms;
    figures[std::string(run.key) + "ack_p99_ms"] = o->ack_p99_ms;
  }
  save(out, figures);
  return true;
}

/// PostgreSQL in memory: what is measured is merging.
bool bench_scaling(const ScalingPlan& plan, const std::filesystem::path& out) {
  run_on_core(0);
  const auto cluster = test::PostgresCluster::make();
  if (!cluster) return std::fprintf(stderr, "servers: %s\n", cluster.error().message.c_str()), false;
  const test::ScratchFolder scratch;
  const auto figures = scaling(plan, **cluster, scratch.path(), [&](const Json& so_far) { save(out, so_far); });
  if (!figures) std::fprintf(stderr, "servers: %s\n", figures.error().message.c_str());
  return figures.has_value();
}

int servers_main(int argc, char** argv, const std::filesystem::path& out) {
  CLI::App app(
      "Two servers on one PostgreSQL under kills, what they cost robots, and what they merge; without a part: all.",
      "./run bench servers");
  app.fallthrough();  // the parts take the options, too
  ServersPlan kills;
  auto* kills_part = app.add_subcommand("kills", "kill -9 of servers, PostgreSQL and robots, all compared");
  LoadPlan load{.seconds = 60};
  auto* acks_part = app.add_subcommand("acks", "keyframe to ack with many robots, beside SQLite");
  ScalingPlan merges;
  auto* scaling_part = app.add_subcommand("scaling", "merging with a server that stands by over merging without one");
  app.add_option("--sessions", merges.sessions, "of the scaling, each in a mine of its own")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--visits", merges.visits, "of the scaling, to these mines")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--runs", merges.pairs, "pairs of runs of the scaling")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--count", kills.count, "kills")->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--seed", kills.seed)->capture_default_str();
  app.add_option("--robots", load.robots, "of the acks")->check(CLI::Range(1, 10000))->capture_default_str();
  app.add_option("--seconds", load.seconds, "of the acks, over each database")
      ->check(CLI::Range(1, 86400))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (test::PostgresCluster::programs().empty())
    return std::fprintf(stderr, "%s\n", test::PostgresCluster::not_installed), 1;
  const bool all = app.get_subcommands().empty();
  bool good = true;
  if (all || acks_part->parsed()) good = bench_acks(load, out) && good;
  if (all || kills_part->parsed()) good = bench_kills(kills, out) && good;
  if (all || scaling_part->parsed()) good = bench_scaling(merges, out) && good;
  return good ? 0 : 1;
}

}  // namespace
}  // namespace headframe::bench

int main(int argc, char** argv) { return headframe::bench::servers_main(argc, argv, "build/bench/servers.json"); }
