#include "tests/bench/stages.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/descriptor/family.hpp"
#include "tests/bench/made_sets.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/pipeline_run.hpp"
#include "tests/bench/verdict_rows.hpp"

namespace headframe::bench {
namespace {

constexpr double right_m = 4, right_deg = 15;   // within the reach of a registration
constexpr double merged_m = 1, merged_deg = 3;  // of a merge, near the overlap
constexpr double apart_m = 10;                  // trajectories that never come nearer do not overlap

struct PairRow {
  std::string set, world, a, b;
  double overlap_pct = 0, nearest_m = 0;
  int rank = -1;  // of the right proposal, from 0; -1: none
  ProposalSource source = ProposalSource::walls;
  int proposals = 0;
  bool screened = false;
  Judgement oracle;
  bool merged = false, right = false;
  double te_m = -1, ms = 0;
  StageTimes times;
  std::optional<Evidence> found;  // of the alignment that was recorded, with its error
  double found_te_m = -1;
};

/// Where the sessions truly meet, as their reported poses have it: from the middle one of the pairs of poses that lie
/// within near_m of each other.
Pose true_placement(const test::TruePath& a, const test::TruePath& b, double near_m) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t j = 0; j < b.T_world_sensor.size(); ++j) {
    std::size_t best = 0;
    double least = near_m;
    for (std::size_t i = 0; i < a.T_world_sensor.size(); ++i) {
      const double d = (a.T_world_sensor[i].translation() - b.T_world_sensor[j].translation()).norm();
      if (d <= least) {
        least = d;
        best = i;
      }
    }
    if (least < near_m) pairs.emplace_back(best, j);
  }
  if (pairs.empty()) return Pose::Identity();
  const auto [i, j] = pairs[pairs.size() / 2];
  return a.T_local_sensor[i] * a.T_world_sensor[i].inverse() * b.T_world_sensor[j] * b.T_local_sensor[j].inverse();
}

/// What two sessions truly have in common.
struct InCommon {
  double overlap_pct = 0, nearest_m = 0;
};

class PairStudy {
 public:
  PairStudy(const DrivenSession& a, const DrivenSession& b, const InCommon& truth) : a_(a), b_(b) {
    row_.set = a.name;
    row_.world = kind_of(a.world);
    row_.a = a.name;
    row_.b = b.name;
    row_.overlap_pct = truth.overlap_pct;
    row_.nearest_m = truth.nearest_m;
    near_m_ = std::max(8.0, row_.nearest_m + 4);
  }

  PairRow run(VerdictRows& rows) {
    PipelineRun run;
    run.add(a_);
    run.take_as_tried();
    run.add(b_);
    row_.ms = wall_ms([&] { row_.times = run.attempt(2); });
    row_.ms -= row_.times.loop_closures_ms;  // after the merge was told
    for (const PairTrace& trace : run.traces) {
      row_.proposals = std::max(row_.proposals, static_cast<int>(trace.proposed.size()));
      for (std::size_t i = 0; i < trace.proposed.size(); ++i)
        if (row_.rank < 0 && near(trace.proposed[i].T_a_b, right_m, right_deg)) {
          row_.rank = static_cast<int>(i);
          row_.source = trace.proposed[i].source;
        }
      for (const Pose& T : trace.screened) row_.screened = row_.screened || near(T, 1.5, 4);
    }
    for (const Alignment& k : run.pipeline.alignments()) {
      row_.found = k.evidence;
      row_.found_te_m = overlaps() ? overlap_error(a_.path, b_.path, k.T_a_b, near_m_).translation_m : -1;
      row_.merged = k.state == AlignmentState::published;
      row_.right = row_.merged && near(k.T_a_b, merged_m, merged_deg);
      row_.te_m = row_.merged ? row_.found_te_m : -1;
    }
    rows.add(run);
    if (!overlaps()) return row_;
    row_.oracle = run.judge(1, 2, true_placement(a_.path, b_.path, near_m_));
    rows.add_oracle(a_, b_, row_.oracle);
    return row_;
  }

 private:
  bool overlaps() const { return row_.overlap_pct >= 1 && near_m_ < 60; }
  bool near(const Pose& T_a_b, double metres, double degrees) const {
    if (!overlaps()) return false;
    const auto error = overlap_error(a_.path, b_.path, T_a_b, near_m_);
    return error.pairs > 0 && error.translation_m < metres && error.rotation_deg < degrees;
  }

  const DrivenSession &a_, &b_;
  double near_m_ = 8;
  PairRow row_;
};

bool degenerate(const PairRow& r) { return r.oracle.status == RegistrationStatus::degenerate; }

const char* bin_of(const PairRow& r) {
  if (r.overlap_pct < 5) return "none";
  if (r.nearest_m >= apart_m) return "apart_paths";
  if (r.overlap_pct >= 30) return "o30";
  if (r.overlap_pct >= 18) return "o18";
  return r.overlap_pct >= 10 ? "o10" : "o05";
}

struct Counts {
  int pairs = 0, degenerate = 0, proposed = 0, screened = 0, oracle = 0, oracle_lost = 0, merged = 0, wrong = 0;
  void add(const PairRow& r) {
    ++pairs;
    degenerate += headframe::bench::degenerate(r);
    proposed += r.rank >= 0;
    screened += r.screened;
    const bool believed = r.oracle.evidence.probability >= MergeConfig{}.accept_probability;
    oracle += believed;
    oracle_lost += believed && r.rank >= 0 && !r.screened;
    merged += r.right;
    wrong += r.merged && !r.right;
  }
  nlohmann::json json() const {
    return {{"pairs", pairs},   {"degenerate", degenerate},   {"proposed", proposed}, {"screened", screened},
            {"oracle", oracle}, {"oracle_lost", oracle_lost}, {"merged", merged},     {"wrong", wrong}};
  }
  void print(const std::string& name) const {
    std::printf("  %-24s %5d %6d %8d %8d %6d %6d %6d %6d\n", name.c_str(), pairs, degenerate, proposed, screened,
                oracle, oracle_lost, merged, wrong);
  }
};

constexpr const char* bins[] = {"o30", "o18", "o10", "o05", "apart_paths", "none"};

void write_csv(const std::vector<PairRow>& rows, const std::filesystem::path& file) {
  std::ofstream csv(file);
  csv << "set,a,b,overlap_pct,nearest_m,bin,source,rank,proposals,screened,oracle_p,oracle_status,merged,right,te_m,ms,"
         "found_p,"
         "found_te_m";
  for (const auto& field : evidence_fields()) csv << ",oracle_" << field.name;
  for (const auto& field : evidence_fields()) csv << ",found_" << field.name;
  csv << "\n";
  for (const PairRow& r : rows) {
    const Evidence found = r.found.value_or(Evidence{});
    csv << r.set << ',' << r.a << ',' << r.b << ',' << r.overlap_pct << ',' << r.nearest_m << ',' << bin_of(r) << ','
        << static_cast<int>(r.source) << ',' << r.rank << ',' << r.proposals << ',' << r.screened << ','
        << r.oracle.evidence.probability << ',' << to_string(r.oracle.status) << ',' << r.merged << ',' << r.right
        << ',' << r.te_m << ',' << r.ms << ',' << found.probability << ',' << r.found_te_m;
    for (const auto& field : evidence_fields()) csv << ',' << r.oracle.evidence.*field.member;
    for (const auto& field : evidence_fields()) csv << ',' << found.*field.member;
    csv << "\n";
  }
}

void print_lost(const PairRow& r) {
  const Evidence& o = r.oracle.evidence;
  std::printf(
      "    %-16s %-20s %-11s %4.1f %% near %4.1f m: rank %d of %d (source %d), screened %d, oracle %s p %.3f "
      "(%.0f/%.0f "
      "places, worst %.4f, misfit %.3f, inliers %.2f, alike %.2f, shared %.0f m, aliases %.0f), found p %.3f %.2f "
      "m%s\n",
      r.set.c_str(), r.b.c_str(), bin_of(r), r.overlap_pct, r.nearest_m, r.rank, r.proposals,
      static_cast<int>(r.source), r.screened, std::string(to_string(r.oracle.status)).c_str(), o.probability,
      o.places_agreeing, o.places, o.worst_place_violation, o.residual_m, o.inlier_fraction, o.descriptors_alike,
      o.overlap_m, o.aliases, r.found ? r.found->probability : -1, r.found_te_m, r.merged && !r.right ? "  WRONG" : "");
}

void print_if_lost(const PairRow& row) {
  if (!row.right && (row.overlap_pct >= 1 || row.merged)) print_lost(row);
}

/// Share of the poses of the one that has fewer within 8 m of the other's, in place of the share of rock.
InCommon path_in_common(const DrivenSession& a, const DrivenSession& b) {
  const bool a_is_less = a.path.T_world_sensor.size() < b.path.T_world_sensor.size();
  const auto &of = (a_is_less ? a : b).path.T_world_sensor, &other = (a_is_less ? b : a).path.T_world_sensor;
  InCommon out{0, 1e9};
  for (const Pose& T : of) {
    double nearest_m = 1e9;
    for (const Pose& U : other) nearest_m = std::min(nearest_m, (T.translation() - U.translation()).norm());
    out.nearest_m = std::min(out.nearest_m, nearest_m);
    out.overlap_pct += nearest_m < 8 ? 100.0 / static_cast<double>(of.size()) : 0;
  }
  return out;
}

nlohmann::json summed_up(const std::vector<PairRow>& rows) {
  nlohmann::json out;
  std::map<std::string, Counts> by_bin, by_world;
  std::vector<double> ms, hypotheses_ms, registration_ms, verification_ms;
  int wrong = 0;
  for (const PairRow& r : rows) {
    by_bin[bin_of(r)].add(r);
    by_world[r.world + " " + bin_of(r)].add(r);
    ms.push_back(r.ms);
    hypotheses_ms.push_back(r.times.hypotheses_ms);
    registration_ms.push_back(r.times.registration_ms);
    verification_ms.push_back(r.times.verification_ms);
    wrong += r.merged && !r.right;
  }
  std::printf("stages: %zu pairs of sessions\n  %-24s %5s %6s %8s %8s %6s %6s %6s %6s\n", rows.size(), "", "pairs",
              "slides", "proposed", "screened", "oracle", "lost", "merged", "wrong");
  for (const char* bin : bins) {
    by_bin[bin].print(bin);
    out[bin] = by_bin[bin].json();
  }
  for (const auto& [name, counts] : by_world) {
    counts.print(name);
    out["worlds"][name] = counts.json();
  }
  out["false"] = wrong;
  out["attempt_p50_ms"] = quantile(ms, 0.5);
  out["attempt_p95_ms"] = quantile(ms, 0.95);
  std::printf(
      "  wrong %d; attempt p50 %.0f ms, p95 %.0f ms; of it proposals %.0f, screening %.0f, verification %.0f ms\n",
      wrong, quantile(ms, 0.5), quantile(ms, 0.95), quantile(hypotheses_ms, 0.5), quantile(registration_ms, 0.5),
      quantile(verification_ms, 0.5));
  return out;
}

}  // namespace

nlohmann::json stages(const std::vector<std::filesystem::path>& folders, const std::vector<std::string>& families,
                      double days_apart, const std::filesystem::path& out) {
  const auto sets = sets_below(folders);
  std::vector<PairRow> rows;
  VerdictRows evidence(out / "verdict_sets.csv");
  for (const auto& set : sets) {
    const auto truth = truth_of(set);
    const auto sessions = sessions_of(set, families, days_apart);
    for (const auto& pair : truth.at("pairs")) {
      const InCommon common{pair.at("overlap_pct"), pair.at("nearest_poses_m")};
      rows.push_back(PairStudy(sessions.at(pair.at("a")), sessions.at(pair.at("b")), common).run(evidence));
      print_if_lost(rows.back());
    }
    std::fprintf(stderr, "\r%zu of %zu data sets", static_cast<std::size_t>(&set - sets.data()) + 1, sets.size());
  }
  std::fprintf(stderr, "\n");
  write_csv(rows, out / "stages.csv");
  return summed_up(rows);
}

nlohmann::json stages_crossed(const std::vector<std::filesystem::path>& folders,
                              const std::vector<std::string>& families, double days_apart,
                              const std::filesystem::path& out) {
  std::map<std::string, std::vector<DrivenSession>> by_kind;
  double later_s = 0;  // sets follow each other as robots do
  for (const auto& set : sets_below(folders)) {
    const auto of_set = sessions_of(set, families, days_apart);
    for (const auto& [robot, session] : of_set) {
      by_kind[kind_of(session.world)].push_back(session);
      for (Keyframe& keyframe : by_kind[kind_of(session.world)].back().keyframes) keyframe.stamp_s += later_s;
    }
    later_s += days_apart * 86400 * static_cast<double>(of_set.size());
  }
  std::vector<PairRow> rows;
  VerdictRows evidence(out / "verdict_crossed.csv");
  for (auto& [kind, sessions] : by_kind) {
    std::vector<std::string> sets;
    for (DrivenSession& session : sessions) sets.push_back(std::exchange(session.world, kind));
    for (std::size_t i = 0; i < sessions.size(); ++i)
      for (std::size_t j = i + 1; j < sessions.size(); ++j) {
        if (sets[i] == sets[j]) continue;
        rows.push_back(PairStudy(sessions[i], sessions[j], path_in_common(sessions[i], sessions[j])).run(evidence));
        print_if_lost(rows.back());
        std::fprintf(stderr, "\r%s: session %zu of %zu", kind.c_str(), i + 1, sessions.size());
      }
  }
  std::fprintf(stderr, "\n");
  write_csv(rows, out / "stages_crossed.csv");
  return summed_up(rows);
}

}  // namespace headframe::bench
