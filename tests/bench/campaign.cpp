#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/picture/top_view.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/merges.hpp"
#include "tests/bench/pipeline_run.hpp"
#include "tests/bench/verdict_rows.hpp"

namespace headframe::bench {
namespace {

constexpr double bar_overlap_pct = 18;

struct Sent {
  std::size_t clouds = 0, of = 0;
};

struct PairResult {
  std::string kind, a, b;
  double overlap_pct = 0;
  bool drift = true;
  bool merged = false, right = false;
  double te_m = -1, re_deg = -1;
  Evidence evidence = {};
};

mine::Request request_for(mine::Kind kind, std::uint64_t first_seed, std::uint64_t number) {
  static constexpr std::array overlaps{20.0, 30.0, 45.0, 25.0, 60.0, 35.0, 22.0};
  static const std::vector<std::vector<std::string>> sensors{{"os1-32", "vlp16-hires", "os1-32"},
                                                             {"vlp16-hires", "os1-32", "vlp16-hires"},
                                                             {"os1-32", "os1-32", "vlp16-hires"}};
  mine::Request r;
  r.kind = kind;
  r.seed = first_seed + number;
  r.robots = 3;
  r.overlap_pct = overlaps[number % overlaps.size()];
  r.length_m = 150;
  r.scan_spacing_m = 1;
  r.sensors = sensors[number % sensors.size()];
  r.drift = number % 4 == 3 ? 0 : 1;
  r.dust = number % 2 == 0 ? 0.003 : 0.01;
  return r;
}

/// The mine, with shorter drives where it is too small for long ones.
DrivenMine drive_somehow(mine::Request request) {
  for (;; request.length_m -= 30) try {
      return drive_mine(request);
    } catch (const std::runtime_error&) {
      if (request.length_m < 100) throw;
    }
}

const Alignment* alignment_of(const PipelineRun& run, SessionId a, SessionId b) {
  for (const Alignment& alignment : run.pipeline.alignments())
    if (alignment.a == a && alignment.b == b) return &alignment;
  return nullptr;
}

picture::Layer layer_of(const DrivenSession& session, const Pose& T, std::size_t colour) {
  picture::Layer layer;
  layer.T_view_cloud = T;
  layer.colour = picture::colour_of(colour);
  for (std::size_t i = 0; i < session.keyframes.size(); ++i) {
    const Eigen::Isometry3f T_f = session.keyframes[i].T_local_sensor.cast<float>();
    layer.trajectory.push_back(session.keyframes[i].T_local_sensor.translation());
    for (const Sweep& sweep : session.clouds[i].sweeps)
      for (std::size_t k = 0; k < sweep.points.size(); k += 8) layer.points.push_back(T_f * sweep.points[k]);
  }
  return layer;
}

void draw(const PipelineRun& run, SessionId a, SessionId b, const PairResult& result,
          const std::filesystem::path& file) {
  const Alignment* found = alignment_of(run, a, b);
  picture::TopView view;
  view.title = result.a + " and " + result.b;
  char line[160];
  std::snprintf(line, sizeof line, "overlap %.0f %%, %s, probability %.3f", result.overlap_pct,
                result.merged ? (result.right ? "merged" : "merged WRONGLY") : "not merged",
                result.evidence.probability);
  view.subtitle = line;
  std::snprintf(line, sizeof line, ", %.2f m off", result.te_m);
  if (result.te_m >= 0) view.subtitle += line;
  view.panels = {{"as placed best",
                  {layer_of(run.session(a), Pose::Identity(), 0),
                   layer_of(run.session(b), found ? found->T_a_b : Pose::Identity(), 1)}}};
  (void)picture::write_png(view, file);
}

/// Two mines of a kind in one database: 6 pairs within them, 9 across. What was sent of their clouds.
Sent run_batch(const Campaign& campaign, mine::Kind kind, std::uint64_t number, std::vector<PairResult>& results,
               VerdictRows& evidence) {
  std::vector<DrivenMine> mines;
  for (const std::uint64_t n : {number, number + 1})
    mines.push_back(drive_somehow(request_for(kind, campaign.first_seed, n)));
  PipelineRun run(campaign.clouds);
  Sent sent;
  for (const DrivenMine& mine : mines)
    for (const DrivenSession& session : mine.sessions) {
      run.add(session);
      sent.of += session.keyframes.size();
    }
  const auto count = static_cast<SessionId>(run.sessions.size());
  for (SessionId id = 1; id <= count; ++id) run.attempt(id);
  evidence.add(run);
  for (SessionId a = 1; a <= count; ++a)
    for (SessionId b = a + 1; b <= count; ++b) {
      PairResult r{std::string(to_string(kind)), run.session(a).name, run.session(b).name};
      const bool same = run.session(a).world == run.session(b).world;
      const auto mine = static_cast<std::size_t>(a > 3), i = static_cast<std::size_t>((a - 1) % 3),
                 j = static_cast<std::size_t>((b - 1) % 3);
      r.overlap_pct = same ? mines[mine].overlap_pct[i][j] : 0;
      r.drift = request_for(kind, campaign.first_seed, number + mine).drift > 0;
      const Outcome outcome = judge_outcome(run, a, b);
      r.merged = outcome.merged;
      r.right = outcome.right;
      r.te_m = outcome.error.translation_m;
      r.re_deg = outcome.error.rotation_deg;
      if (const Alignment* found = alignment_of(run, a, b)) r.evidence = found->evidence;
      const bool bad = r.merged ? !r.right || r.te_m > 0.4 : r.overlap_pct >= bar_overlap_pct;
      if (bad) draw(run, a, b, r, campaign.out / (r.kind + "-" + std::to_string(results.size()) + ".png"));
      results.push_back(r);
    }
  sent.clouds = campaign.clouds == Clouds::at_once ? sent.of : run.came();
  return sent;
}

struct KindRow {
  int pairs = 0, merged = 0, wrong = 0;
  std::vector<double> te_m, re_deg;
};

nlohmann::json print_row(const std::string& name, const KindRow& row) {
  std::printf("  %-28s %5d %7d %6d %9.3f %9.2f\n", name.c_str(), row.pairs, row.merged, row.wrong,
              quantile(row.te_m, 0.5), quantile(row.re_deg, 0.5));
  return {{"pairs", row.pairs},
          {"merged", row.merged},
          {"false", row.wrong},
          {"te_m", quantile(row.te_m, 0.5)},
          {"re_deg", quantile(row.re_deg, 0.5)}};
}

template <class Belongs>
KindRow row_of(const std::vector<PairResult>& results, Belongs&& belongs) {
  KindRow row;
  for (const PairResult& r : results) {
    if (!belongs(r)) continue;
    ++row.pairs;
    row.merged += r.merged && r.right;
    row.wrong += r.merged && !r.right;
    if (!r.right) continue;
    row.te_m.push_back(r.te_m);
    row.re_deg.push_back(r.re_deg);
  }
  return row;
}

/// Where an alignment can be known from the rock: in a mine of exact copies, and in one that is smooth for 100 m, a
/// pair may have to wait. Their rows are given by themselves.
bool knowable(const PairResult& r) { return r.kind != "look_alike" && r.kind != "straight"; }

}  // namespace

nlohmann::json run_campaign(const Campaign& campaign) {
  std::filesystem::create_directories(campaign.out);
  Sent sent;
  std::vector<PairResult> results;
  VerdictRows evidence(campaign.out / "verdict.csv");
  for (int m = 0; m + 1 < campaign.mines; m += 2) {
    const auto kind = campaign.kinds[static_cast<std::size_t>(m / 2) % campaign.kinds.size()];
    std::fprintf(stderr, "\rmines %d of %d, %zu pairs", m + 2, campaign.mines, results.size());
    const Sent more = run_batch(campaign, kind, static_cast<std::uint64_t>(m), results, evidence);
    sent.clouds += more.clouds;
    sent.of += more.of;
  }
  std::fprintf(stderr, "\n");
  std::printf(
      "merges: pairs, merged rightly, merged wrongly, median error near the overlap\n  %-28s %5s %7s %6s %9s %9s\n", "",
      "pairs", "merged", "wrong", "m", "deg");
  nlohmann::json out;
  const auto add = [&](const std::string& name, auto&& belongs) {
    out["rows"][name] = print_row(name, row_of(results, belongs));
  };
  for (const auto kind : campaign.kinds) {
    const std::string name(to_string(kind));
    add(name + ", overlap >= 18 %", [&](const auto& r) { return r.kind == name && r.overlap_pct >= bar_overlap_pct; });
    add(name + ", nothing shared", [&](const auto& r) { return r.kind == name && r.overlap_pct == 0; });
  }
  for (const auto& range : {std::pair{0.001, 10.0}, {10.0, 18.0}, {18.0, 25.0}, {25.0, 40.0}, {40.0, 100.0}})
    add("overlap " + std::to_string(static_cast<int>(range.first)) + " to " +
            std::to_string(static_cast<int>(range.second)) + " %",
        [&](const auto& r) { return knowable(r) && r.overlap_pct >= range.first && r.overlap_pct < range.second; });
  const KindRow all = row_of(results, [](const auto&) { return true; });
  const KindRow bar = row_of(results, [](const auto& r) { return knowable(r) && r.overlap_pct >= bar_overlap_pct; });
  const KindRow still = row_of(results, [](const auto& r) { return knowable(r) && !r.drift; });
  const double recall = bar.pairs > 0 ? static_cast<double>(bar.merged) / bar.pairs : 0;
  // No false merge in n: the rate is below this with 95 % confidence (1 - 0.05^(1/n)).
  const double bound = all.pairs > 0 && all.wrong == 0 ? 1 - std::pow(0.05, 1.0 / all.pairs) : -1;
  std::printf("  %d pairs: %d false", all.pairs, all.wrong);
  if (bound >= 0) std::printf(" (95 %% upper bound of the rate %.4f)", bound);
  std::printf("; recall %.3f (%d of %d with >= 18 %%); without drift %.3f m %.2f deg\n", recall, bar.merged, bar.pairs,
              quantile(still.te_m, 0.5), quantile(still.re_deg, 0.5));
  std::printf("  %zu of %zu clouds sent\n", sent.clouds, sent.of);
  for (const PairResult& r : results)
    if (r.merged ? !r.right : knowable(r) && r.overlap_pct >= bar_overlap_pct)
      std::printf(
          "  %s: %s and %s, overlap %.0f %%, p %.3f, violations %.4f, misfit %.3f m, %.0f m shared, %.0f aliases\n",
          r.merged ? "FALSE" : "missed", r.a.c_str(), r.b.c_str(), r.overlap_pct, r.evidence.probability,
          r.evidence.freespace_violation, r.evidence.residual_m, r.evidence.overlap_m, r.evidence.aliases);
  out.update({{"pairs", all.pairs},
              {"clouds", sent.clouds},
              {"clouds_in_all", sent.of},
              {"false", all.wrong},
              {"false_rate_bound_95", bound},
              {"recall", recall},
              {"te_m", quantile(still.te_m, 0.5)},
              {"re_deg", quantile(still.re_deg, 0.5)},
              {"te_drift_m", quantile(bar.te_m, 0.5)},
              {"re_drift_deg", quantile(bar.re_deg, 0.5)}});
  return out;
}

}  // namespace headframe::bench
