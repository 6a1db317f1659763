#include "tests/bench/link/parts.hpp"

#include <cstdio>
#include <thread>

#include "tests/bench/link/faults.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/postgres_cluster.hpp"

namespace headframe::bench {
namespace {

constexpr double ack_bar_ms = 250;

void print(const LoadOutcome& o) {
  std::printf("  %6d %9llu %8.1f %8.1f %9.1f %8llu %8llu %8.1f %+8.1f %+8.1f %7.2f %7.2f %7.0f %s\n", o.robots,
              static_cast<unsigned long long>(o.keyframes), o.ack_p50_ms, o.ack_p99_ms, o.ack_max_ms,
              static_cast<unsigned long long>(o.unacknowledged), static_cast<unsigned long long>(o.broken_links),
              o.rss_mb, o.rss_growth_mb, o.rss_growth_half_mb, o.server_cores, o.robots_cores, o.late_ms,
              o.broken_why.c_str());
  std::fflush(stdout);
}

/// A folder in memory where there is one: robots have disks of their own. The server's data stay on the disk.
Result<LoadOutcome> load_once(const LoadPlan& plan) {
  const test::ScratchFolder disk;
  const std::filesystem::path memory = "/dev/shm";
  const auto spools = std::filesystem::is_directory(memory) ? memory / disk.path().filename() : disk.path() / "robots";
  auto outcome = load(plan, disk.path(), spools);
  std::error_code ignored;
  std::filesystem::remove_all(spools, ignored);
  return outcome;
}

nlohmann::json figures_of(const KillOutcome& outcome, std::uint32_t seed) {
  const Faults& f = outcome.faults;
  return {{"kill_seed", seed},
          {"kills", outcome.kills},
          {"lost", f.lost + f.clouds_lost},
          {"duplicated", f.duplicated},
          {"corrupted", f.corrupted},
          {"clouds_lost", f.clouds_lost},
          {"clouds_corrupted", f.clouds_corrupted},
          {"kill_keyframes", f.keyframes},
          {"kill_clouds", f.clouds},
          {"kill_compares", outcome.compares},
          {"server_kills", outcome.server_kills}};
}

KillOutcome outcome_of(const nlohmann::json& figures) {
  const auto count = [&](const char* name) { return figures.value(name, std::uint64_t{0}); };
  KillOutcome outcome;
  outcome.kills = figures.value("kills", 0);
  outcome.server_kills = figures.value("server_kills", 0);
  outcome.compares = figures.value("kill_compares", 0);
  Faults& f = outcome.faults;
  f.clouds_lost = count("clouds_lost");
  f.lost = count("lost") - f.clouds_lost;
  f.duplicated = count("duplicated");
  f.corrupted = count("corrupted");
  f.clouds_corrupted = count("clouds_corrupted");
  f.keyframes = count("kill_keyframes");
  f.clouds = count("kill_clouds");
  return outcome;
}

}  // namespace

nlohmann::json link_kills(const KillPlan& plan, const nlohmann::json& before,
                          const std::function<void(const nlohmann::json&)>& save) {
  KillOutcome earlier;
  if (before.value("kill_seed", 0U) == plan.seed && before.value("kills", 0) < plan.count) earlier = outcome_of(before);
  if (earlier.kills > 0) std::printf("link kills: goes on after %d kills of an earlier run\n", earlier.kills);
  const test::ScratchFolder scratch;
  const auto outcome = kill_campaign(plan, scratch.path(), earlier, [&](const KillOutcome& so_far) {
    save(figures_of(so_far, plan.seed));
    std::fprintf(stderr, "link kills: %d of %d\n", so_far.kills, plan.count);
  });
  if (!outcome) return std::fprintf(stderr, "link kills: %s\n", outcome.error().message.c_str()), nlohmann::json();
  const Faults& f = outcome->faults;
  const auto n = [](std::uint64_t v) { return static_cast<unsigned long long>(v); };
  std::printf(
      "link kills (seed %u)\n  %d kills, %d of them of the server; %d compares; %llu keyframes and %llu clouds\n",
      plan.seed, outcome->kills, outcome->server_kills, outcome->compares, n(f.keyframes), n(f.clouds));
  std::printf("  lost %llu, duplicated %llu, corrupted %llu; clouds lost %llu, corrupted %llu %s\n", n(f.lost),
              n(f.duplicated), n(f.corrupted), n(f.clouds_lost), n(f.clouds_corrupted), f.first.c_str());
  return figures_of(*outcome, plan.seed);
}

nlohmann::json link_faults(double seconds, std::uint32_t seed) {
  constexpr std::size_t robots = 4, robots_together = 12;  // the last row's tail is what has to be known well
  const test::ScratchFolder scratch;
  const auto radios = bad_radios();
  std::vector<std::size_t> radio_of;
  for (std::size_t r = 0; r < radios.size(); ++r)
    radio_of.insert(radio_of.end(), r + 1 < radios.size() ? robots : robots_together, r);
  std::vector<Result<FaultOutcome>> runs(radio_of.size());
  std::vector<FaultOutcome> outcomes(radios.size());
  std::vector<std::thread> threads;
  threads.reserve(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i)
    threads.emplace_back([&, i] {
      const FaultPlan plan{radios[radio_of[i]], seconds, 1, seed + static_cast<std::uint32_t>(i)};
      runs[i] = drive_over(plan, scratch.path() / std::to_string(i));
    });
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i]) return std::fprintf(stderr, "link faults: %s\n", runs[i].error().message.c_str()), nlohmann::json();
    outcomes[radio_of[i]].add(*runs[i]);
  }
  nlohmann::json rows = nlohmann::json::array(), figures;
  std::uint64_t wrong = 0;
  std::printf(
      "link faults (%.0f s each; 4 robots, 12 in the last row, each over a radio of its own, a keyframe a second with "
      "its cloud)\n"
      "  radio             keyframes  lag p50 s  p95 s  max s  recovery p95 s  clouds meanwhile  lost  doubled  "
      "corrupt\n",
      seconds);
  for (std::size_t r = 0; r < radios.size(); ++r) {
    const FaultOutcome& done = outcomes[r];
    const auto& f = done.faults;
    const double p50 = quantile(done.lag_s, 0.5), p95 = quantile(done.lag_s, 0.95), most = quantile(done.lag_s, 1);
    const double recovery = quantile(done.recovery_s, 0.95);
    std::printf("  %-16s %10llu %10.2f %6.2f %6.2f %15.2f %17llu %5llu %8llu %8llu %s\n", radios[r].name.c_str(),
                static_cast<unsigned long long>(f.keyframes), p50, p95, most, recovery,
                static_cast<unsigned long long>(done.clouds), static_cast<unsigned long long>(f.lost) + f.clouds_lost,
                static_cast<unsigned long long>(f.duplicated),
                static_cast<unsigned long long>(f.corrupted) + f.clouds_corrupted, f.first.c_str());
    wrong += f.sum();
    rows.push_back({{"radio", radios[r].name},
                    {"keyframes", f.keyframes},
                    {"lag_p50_s", p50},
                    {"lag_p95_s", p95},
                    {"lag_max_s", most},
                    {"recovery_p95_s", recovery},
                    {"clouds", done.clouds},
                    {"bytes", done.bytes},
                    {"faults", f.sum()}});
  }
  return {{"radios", rows},
          {"radio_faults", wrong},
          {"recovery_p95_s", rows[3]["recovery_p95_s"]},
          {"recovery_together_p95_s", rows[4]["recovery_p95_s"]},
          {"lag_64kbit_max_s", rows[2]["lag_max_s"]}};
}

nlohmann::json link_load(const LoadPlan& plan, bool until_it_breaks) {
  std::printf(
      "link load (%.0f s, a keyframe a second each with a cloud of %d points)\n"
      "  robots keyframes   p50 ms   p99 ms    max ms  unacked  dropped   rss MB   growth 2nd half  server  robots "
      "late ms\n",
      plan.seconds, plan.points);
  const auto first = load_once(plan);
  if (!first) return std::fprintf(stderr, "link load: %s\n", first.error().message.c_str()), nlohmann::json();
  print(*first);
  nlohmann::json figures{{"robots", first->robots},
                         {"ack_p50_ms", first->ack_p50_ms},
                         {"ack_p99_ms", first->ack_p99_ms},
                         {"ack_max_ms", first->ack_max_ms},
                         {"overflows", first->broken_links},
                         {"unacknowledged", first->unacknowledged},
                         {"rss_mb", first->rss_mb},
                         {"rss_growth_mb", first->rss_growth_mb},
                         {"rss_growth_half_mb", first->rss_growth_half_mb},
                         {"load_seconds", plan.seconds},
                         {"server_cores", first->server_cores},
                         {"bench_cores", first->robots_cores}};
  LoadPlan more = plan;
  more.seconds = 30;
  for (auto last = *first; until_it_breaks && last.ack_p99_ms <= ack_bar_ms && last.broken_links == 0;) {
    more.robots = more.robots * 3 / 2;
    const auto next = load_once(more);
    if (!next) return std::fprintf(stderr, "link load: %s\n", next.error().message.c_str()), figures;
    print(*next);
    last = *next;
    figures["breaks_at_robots"] = last.robots;
  }
  return figures;
}

nlohmann::json link_stores(LoadPlan plan) {
  const auto cluster = test::PostgresCluster::make(std::filesystem::temp_directory_path());
  if (!cluster) return std::fprintf(stderr, "link stores: %s\n", cluster.error().message.c_str()), nlohmann::json();
  std::printf(
      "link stores (%d robots, %.0f s, a keyframe a second each with a cloud of %d points)\n"
      "  store      keyframes   p50 ms   p99 ms    max ms  unacked  server cores  late ms\n",
      plan.robots, plan.seconds, plan.points);
  nlohmann::json figures;
  for (const bool postgres : {false, true, false, true}) {
    auto url = postgres ? (*cluster)->make_database() : Result<std::string>("");
    if (!url) return std::fprintf(stderr, "link stores: %s\n", url.error().message.c_str()), nlohmann::json();
    plan.store_url = *url;
    const auto o = load_once(plan);
    if (!o) return std::fprintf(stderr, "link stores: %s\n", o.error().message.c_str()), nlohmann::json();
    const char* name = postgres ? "postgresql" : "sqlite";
    std::printf("  %-10s %9llu %8.1f %8.1f %9.1f %8llu %13.2f %8.0f\n", name,
                static_cast<unsigned long long>(o->keyframes), o->ack_p50_ms, o->ack_p99_ms, o->ack_max_ms,
                static_cast<unsigned long long>(o->unacknowledged), o->server_cores, o->late_ms);
    std::fflush(stdout);
    figures["stores"][name].push_back({{"ack_p50_ms", o->ack_p50_ms},
                                       {"ack_p99_ms", o->ack_p99_ms},
                                       {"unacknowledged", o->unacknowledged},
                                       {"server_cores", o->server_cores}});
  }
  return figures;
}

}  // namespace headframe::bench
