#include <array>
#include <cstdio>

#include "tests/bench/measure.hpp"
#include "tests/bench/merges.hpp"
#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {
namespace {

/// Two robots of 300 keyframes, a metre apart, that share about a quarter.
DrivenMine long_drives(mine::Kind kind, std::uint64_t seed) {
  mine::Request r;
  r.kind = kind;
  r.seed = seed;
  r.overlap_pct = 30;
  r.length_m = 310;
  r.scan_spacing_m = 1;
  r.sensors = {"os1-32", "vlp16-hires"};
  for (;; r.length_m -= 20) try {
      DrivenMine mine = drive_mine(r, Selection::every_scan);
      for (DrivenSession& s : mine.sessions)
        if (s.keyframes.size() > 300) {
          s.keyframes.resize(300);
          s.clouds.resize(300);
        }
      return mine;
    } catch (const std::runtime_error&) {
      if (r.length_m < 200) throw;
    }
}

struct Timed {
  std::vector<double> total, hypotheses, sampling, registration, verification, atlas;
  int published = 0;
};

void time_merge(const DrivenMine& mine, const std::vector<DrivenSession>& others, Timed& timed) {
  PipelineRun run;
  for (const DrivenSession& other : others) run.add(other);
  run.add(mine.sessions[0]);
  run.take_as_tried();
  const SessionId id = run.add(mine.sessions[1]);
  StageTimes t;
  double ms = wall_ms([&] { t = run.attempt(id); });
  ms -= t.loop_closures_ms;  // after the merge was told
  if (!judge_outcome(run, id - 1, id).merged) return;
  ++timed.published;
  timed.total.push_back(ms);
  timed.hypotheses.push_back(t.hypotheses_ms);
  timed.sampling.push_back(t.sampling_ms);
  timed.registration.push_back(t.registration_ms);
  timed.verification.push_back(t.verification_ms);
  timed.atlas.push_back(t.atlas_ms);
}

}  // namespace

nlohmann::json merge_times() {
  std::vector<DrivenMine> mines;
  static constexpr std::array kinds{mine::Kind::junctions, mine::Kind::grid, mine::Kind::ramp};
  for (std::uint64_t i = 0; i < 9; ++i) mines.push_back(long_drives(kinds[i % kinds.size()], 7000 + i));
  Timed timed;
  std::size_t keyframes = 0;
  for (const DrivenMine& mine : mines) {
    time_merge(mine, {}, timed);
    keyframes += mine.sessions[0].keyframes.size() + mine.sessions[1].keyframes.size();
  }
  std::printf("merge: trigger to published, two sessions of %zu keyframes on average, %d of %zu pairs published\n",
              keyframes / (2 * mines.size()), timed.published, mines.size());
  const double p50 = quantile(timed.total, 0.5), p95 = quantile(timed.total, 0.95);
  std::printf(
      "  p50 %.0f ms, p95 %.0f ms; medians by stage: hypotheses %.0f, clouds %.0f, registration %.0f, evidence %.0f, "
      "atlas %.1f ms\n",
      p50, p95, quantile(timed.hypotheses, 0.5), quantile(timed.sampling, 0.5), quantile(timed.registration, 0.5),
      quantile(timed.verification, 0.5), quantile(timed.atlas, 0.5));
  nlohmann::json out{{"p50_ms", p50},
                     {"p95_ms", p95},
                     {"keyframes", keyframes / (2 * mines.size())},
                     {"stages_ms",
                      {{"hypotheses", quantile(timed.hypotheses, 0.5)},
                       {"clouds", quantile(timed.sampling, 0.5)},
                       {"registration", quantile(timed.registration, 0.5)},
                       {"evidence", quantile(timed.verification, 0.5)},
                       {"atlas", quantile(timed.atlas, 0.5)}}}};
  // Others in the database, of the same kinds: what they add to the same trigger.
  std::vector<DrivenSession> others;
  for (const std::size_t count : {8U, 28U, 98U}) {
    for (std::uint64_t seed = 8000 + others.size(); others.size() < count; seed += 2) {
      mine::Request r;
      r.kind = kinds[seed % kinds.size()];
      r.seed = seed;
      r.overlap_pct = 30;
      r.length_m = 100;
      DrivenMine mine = drive_mine(r);
      for (DrivenSession& s : mine.sessions) others.push_back(std::move(s));
    }
    Timed crowded;
    time_merge(mines[0], {others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count)}, crowded);
    const double ms = quantile(crowded.total, 0.5);
    std::printf("  with %zu sessions in the database: %.0f ms to the end of all attempts\n", count + 2, ms);
    out["by_sessions"][std::to_string(count + 2)] = ms;
  }
  return out;
}

}  // namespace headframe::bench
