#include <algorithm>
#include <cstdio>

#include "tests/bench/link/faults.hpp"
#include "tests/bench/link/hostile_trial.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/support/base_station.hpp"

namespace headframe::bench {
namespace {

constexpr std::size_t every = 6;  // attacks between two trials without one
// A p99 of one trial with nobody who attacks may be 1.4 times their median: what stands out is tried twice more, and
// the middle of the three counts.
constexpr double stands_out = 1.2;

std::vector<Attack> attacks(const std::string& only) {
  std::vector<Attack> all;
  for (const auto& peer : test::hostile_peers())
    all.push_back({peer.name, [&](const test::HostileTarget& target) { (void)peer.attack(target); }});
  for (const auto* acts : {&test::hostile_drives(), &test::hostile_robots(), &test::hostile_clients()})
    for (const auto& act : *acts) all.push_back({act.name, act.act});
  std::erase_if(all, [&](const Attack& attack) { return attack.name.find(only) == std::string::npos; });
  return all;
}

struct Row {
  std::string name;
  double ack_p99_ms = 0, merge_s = 0;
  std::string death;
};

Result<Row> measured(const Attack& attack, double seconds) {
  const test::ScratchFolder scratch;
  const auto trial = hostile_trial(attack, seconds, scratch.path());
  if (!trial) return tl::unexpected(trial.error());
  const Row row{attack.name, quantile(trial->ack_ms, 0.99), trial->merge_s, trial->death};
  std::printf("  %-30s %5d times  ack p50 %6.1f p99 %7.1f ms  merge %6.2f s  %s\n", row.name.c_str(), trial->acts,
              quantile(trial->ack_ms, 0.5), row.ack_p99_ms, row.merge_s, row.death.c_str());
  std::fflush(stdout);
  return row;
}

double median_of(const std::vector<Row>& rows, double Row::*figure) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const Row& row : rows) values.push_back(row.*figure);
  return quantile(values, 0.5);
}

const Row& worst_of(const std::vector<Row>& rows, double Row::*figure) {
  return *std::max_element(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return a.*figure < b.*figure; });
}

Result<void> try_again(Row& row, const Attack& attack, double seconds) {
  std::vector<Row> three{row};
  while (three.size() < 3) {
    const auto again = measured(attack, seconds);
    if (!again) return tl::unexpected(again.error());
    three.push_back(*again);
    if (row.death.empty()) row.death = again->death;
  }
  row.ack_p99_ms = median_of(three, &Row::ack_p99_ms);
  row.merge_s = median_of(three, &Row::merge_s);
  return {};
}

/// Trials of all attacks, and those without one between them.
Result<std::pair<std::vector<Row>, std::vector<Row>>> measure_all(const std::vector<Attack>& all, double seconds) {
  std::vector<Row> alone, beside;
  const auto add = [&](std::vector<Row>& rows, const Attack& attack) -> Result<void> {
    const auto row = measured(attack, seconds);
    if (!row) return tl::unexpected(row.error());
    rows.push_back(*row);
    return {};
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i % every == 0)
      if (auto ok = add(alone, {"nobody attacks", {}}); !ok) return tl::unexpected(ok.error());
    if (auto ok = add(beside, all[i]); !ok) return tl::unexpected(ok.error());
  }
  const double ack_ms = median_of(alone, &Row::ack_p99_ms), merge_s = median_of(alone, &Row::merge_s);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (beside[i].ack_p99_ms > stands_out * ack_ms || beside[i].merge_s > stands_out * merge_s)
      if (auto ok = try_again(beside[i], all[i], seconds); !ok) return tl::unexpected(ok.error());
  return std::pair(alone, beside);
}

}  // namespace

nlohmann::json link_hostile(double seconds, const std::string& only) {
  const auto all = attacks(only);
  if (all.empty()) return std::fprintf(stderr, "link hostile: no attack has that name\n"), nlohmann::json();
  std::printf("link hostile (%.0f s each; six honest robots, ten keyframes a second each; two more that merge)\n",
              seconds);
  const auto rows = measure_all(all, seconds);
  if (!rows) return std::fprintf(stderr, "link hostile: %s\n", rows.error().message.c_str()), nlohmann::json();
  const auto& [alone, beside] = *rows;
  const double ack_ms = median_of(alone, &Row::ack_p99_ms), merge_s = median_of(alone, &Row::merge_s);
  const Row &slowest_ack = worst_of(beside, &Row::ack_p99_ms), &latest = worst_of(beside, &Row::merge_s);
  const auto deaths = std::count_if(beside.begin(), beside.end(), [](const Row& row) { return !row.death.empty(); });
  std::printf("  %zu kinds of attacks, %td deaths; alone: ack p99 %.1f ms, merge %.2f s (medians)\n", beside.size(),
              deaths, ack_ms, merge_s);
  std::printf("  worst ack p99 %.2f times of alone (%s; median %.2f), latest merge %.2f times (%s; median %.2f)\n",
              slowest_ack.ack_p99_ms / ack_ms, slowest_ack.name.c_str(), median_of(beside, &Row::ack_p99_ms) / ack_ms,
              latest.merge_s / merge_s, latest.name.c_str(), median_of(beside, &Row::merge_s) / merge_s);
  return {{"hostile",
           {{"attacks", beside.size()},
            {"deaths", deaths},
            {"ack_ratio", slowest_ack.ack_p99_ms / ack_ms},
            {"merge_ratio", latest.merge_s / merge_s},
            {"ack_ratio_median", median_of(beside, &Row::ack_p99_ms) / ack_ms},
            {"merge_ratio_median", median_of(beside, &Row::merge_s) / merge_s}}}};
}

}  // namespace headframe::bench
