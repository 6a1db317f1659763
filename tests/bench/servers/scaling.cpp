#include "tests/bench/servers/scaling.hpp"

#include <sched.h>

#include <chrono>
#include <cstdio>
#include <future>
#include <optional>
#include <thread>

#include "common/cloud/cloud_codec.hpp"
#include "common/descriptor/family.hpp"
#include "server/store/postgres_store.hpp"
#include "tests/bench/link/load.hpp"
#include "tests/bench/link/quantile.hpp"
#include "tests/bench/link/served.hpp"
#include "tests/bench/years/drawn_years.hpp"

namespace headframe::bench {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

void put(Store& store, SessionId id, const test::Drive& drive) {
  SessionRecord record;
  record.id = id;
  record.key = {"robot " + std::to_string(id), "one"};
  record.sensor = {"drawn", 32, 22.5F, 22.5F, 60};
  record.family = make_family(default_family_name).value()->id();
  record.q_size = static_cast<std::uint32_t>(drive.keyframes.front().descriptor.q.size());
  record.w_size = static_cast<std::uint32_t>(drive.keyframes.front().descriptor.w.size());
  const auto later = [](const Result<void>&) {};
  store.write(PutSession{record}, later);
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
    store.write(PutKeyframe{id, drive.keyframes[i]}, later);
    store.write(PutCloud{{id, drive.keyframes[i].sequence}, encode_cloud(drive.clouds[i]).value()}, later);
  }
  std::promise<Result<void>> done;
  store.write(CompleteSession{id}, [&](const Result<void>& result) { done.set_value(result); });
  if (auto result = done.get_future().get(); !result) throw std::runtime_error(result.error().message);
}

/// As robots left it, and nothing tried.
Result<void> fill(const ScalingPlan& plan, const std::string& url, const std::filesystem::path& folder) {
  auto store = open_postgres_store(folder, url);
  if (!store) return tl::unexpected(store.error());
  SessionId id = 0;
  for (std::size_t i = 1; i <= plan.sessions; ++i) put(**store, ++id, drawn_drive(i, plan.keyframes));
  for (std::size_t i = 1; i <= plan.visits; ++i) put(**store, ++id, drawn_visit(i, plan.keyframes));
  return {};
}

struct Run {
  double wall_s = 0, active_cpu_s = 0, standby_cpu_s = 0;
  std::int64_t searched = 0;  // by the standby server
  std::string merged;         // which pairs
};

class Runs {
 public:
  Runs(test::PostgresCluster& cluster, std::filesystem::path scratch)
      : cluster_(cluster), scratch_(std::move(scratch)) {}

  Result<Run> make(bool with_standby) {
    const std::string name = "run" + std::to_string(++runs_);
    if (auto made = cluster_.execute("CREATE DATABASE " + name + " TEMPLATE mine1"); !made)
      return tl::unexpected(made.error());
    const std::string url = cluster_.url(name);
    const std::string config = "[store]\nurl = \"" + url + "\"\nstandby = true\n[merge]\nthreads = 1\n";
    PostgresDatabase database(url, name);
    if (auto done = database.connect(); !done) return tl::unexpected(done.error());
    run_on_core(0);
    auto active = serve(scratch_ / name, config);
    if (!active) return tl::unexpected(active.error());
    const auto start = Clock::now();
    std::optional<Served> standby;
    if (with_standby) {
      run_on_core(1);
      auto known = make_known_as(*active, scratch_ / (name + "b"));
      auto served = known ? serve(scratch_ / (name + "b"), config) : tl::unexpected(known.error());
      if (!served) return tl::unexpected(served.error());
      standby.emplace(std::move(*served));
      run_on_core(0);
    }
    if (auto done = until_all_are_tried(database, *active); !done) return tl::unexpected(done.error());
    Run run;
    run.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
    run.active_cpu_s = cpu_s(active->process.pid());
    if (standby) run.standby_cpu_s = cpu_s(standby->process.pid());
    (void)database.each("SELECT coalesce(max(searched), 0)::bigint FROM servers",
                        [&](const Row& row) { run.searched = row.integer(0); });
    (void)database.each(
        "SELECT coalesce(string_agg(a || '-' || b || ' ' || state, ', ' ORDER BY a, b), '') FROM alignments",
        [&](const Row& row) { run.merged = row.text(0); });
    return run;
  }

 private:
  static Result<void> until_all_are_tried(PostgresDatabase& database, Served& active) {
    const auto deadline = Clock::now() + 1h;
    while (Clock::now() < deadline && active.process.poll() < 0) {
      std::int64_t left = 0;
      auto read = database.each(
          "SELECT count(*) FROM sessions s WHERE attempted_keyframes <"
          " (SELECT count(*) FROM keyframes k WHERE k.session = s.id)",
          [&](const Row& row) { left = row.integer(0); });
      if (!read || left == 0) return read;
      std::this_thread::sleep_for(50ms);
    }
    return failure(ErrorCode::unavailable, "not every session was tried, see " + active.log.string());
  }

  test::PostgresCluster& cluster_;
  const std::filesystem::path scratch_;
  int runs_ = 0;
};

}  // namespace

void run_on_core(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(core, &set);
  (void)::sched_setaffinity(0, sizeof set, &set);
}

Result<nlohmann::json> scaling(const ScalingPlan& plan, test::PostgresCluster& cluster,
                               const std::filesystem::path& scratch,
                               const std::function<void(const nlohmann::json&)>& after_run) {
  const auto url = cluster.make_database();  // mine1
  if (!url) return tl::unexpected(url.error());
  if (auto filled = fill(plan, *url, scratch / "filled"); !filled) return tl::unexpected(filled.error());
  std::printf("scaling (%zu sessions and %zu visits of %zu keyframes)\n", plan.sessions, plan.visits, plan.keyframes);
  Runs runs(cluster, scratch);
  std::vector<double> ratio, alone_s, beside_s, active_cpu_s, standby_cpu_s, alone_cpu_s;
  nlohmann::json figures;
  int different = 0;
  for (int i = 0; i < plan.pairs; ++i) {
    std::optional<Run> alone, beside;
    for (const bool with_standby : {i % 2 == 1, i % 2 == 0}) {
      auto run = runs.make(with_standby);
      if (!run) return tl::unexpected(run.error());
      (with_standby ? beside : alone) = *run;
    }
    different += alone->merged != beside->merged ? 1 : 0;
    ratio.push_back(alone->wall_s / beside->wall_s);
    alone_s.push_back(alone->wall_s);
    beside_s.push_back(beside->wall_s);
    alone_cpu_s.push_back(alone->active_cpu_s);
    active_cpu_s.push_back(beside->active_cpu_s);
    standby_cpu_s.push_back(beside->standby_cpu_s);
    std::printf(
        "  alone %6.1f s (processor %6.1f s), with a standby server %6.1f s (active %6.1f s, standby %6.1f s, %lld "
        "searches): %.2f times; merged %s\n",
        alone->wall_s, alone->active_cpu_s, beside->wall_s, beside->active_cpu_s, beside->standby_cpu_s,
        static_cast<long long>(beside->searched), ratio.back(),
        alone->merged == beside->merged ? "the same" : (alone->merged + " / " + beside->merged).c_str());
    std::fflush(stdout);
    figures = {{"merge_scaling", quantile(ratio, 0.5)},
               {"merge_scaling_least", quantile(ratio, 0)},
               {"merge_alone_s", quantile(alone_s, 0.5)},
               {"merge_beside_standby_s", quantile(beside_s, 0.5)},
               {"merge_alone_cpu_s", quantile(alone_cpu_s, 0.5)},
               {"merge_active_cpu_s", quantile(active_cpu_s, 0.5)},
               {"merge_standby_cpu_s", quantile(standby_cpu_s, 0.5)},
               {"merge_scaling_runs", i + 1},
               {"merge_scaling_different", different}};
    after_run(figures);
  }
  return figures;
}

}  // namespace headframe::bench
