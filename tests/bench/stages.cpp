#include "tests/bench/stages.hpp"

#include <cstdio>
#include <fstream>
#include <utility>

#include "tests/bench/made_sets.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/pair_study.hpp"

namespace headframe::bench {
namespace {

/// A proposal counts from which registration reached the truth, however far off it was.
bool proposed_right(const PairRow& r) { return r.rank >= 0 || r.screened; }

struct Counts {
  int pairs = 0, degenerate = 0, proposed = 0, screened = 0, oracle = 0, oracle_lost = 0, merged = 0, wrong = 0;
  std::size_t clouds = 0, clouds_sent = 0;
  void add(const PairRow& r) {
    ++pairs;
    degenerate += headframe::bench::degenerate(r);
    proposed += proposed_right(r);
    screened += r.screened;
    const bool believed = r.oracle.evidence.probability >= MergeConfig{}.accept_probability;
    oracle += believed;
    oracle_lost += believed && proposed_right(r) && !r.screened;
    merged += r.right;
    wrong += r.merged && !r.right;
    clouds += r.clouds;
    clouds_sent += r.clouds_sent;
  }
  double sent_pct() const {
    return clouds > 0 ? 100.0 * static_cast<double>(clouds_sent) / static_cast<double>(clouds) : 0;
  }
  nlohmann::json json() const {
    return {{"pairs", pairs},       {"degenerate", degenerate}, {"proposed", proposed},
            {"screened", screened}, {"oracle", oracle},         {"oracle_lost", oracle_lost},
            {"merged", merged},     {"wrong", wrong},           {"clouds_sent_pct", sent_pct()}};
  }
  void print(const std::string& name) const {
    std::printf("  %-24s %5d %6d %8d %8d %6d %6d %6d %6d %6.0f %%\n", name.c_str(), pairs, degenerate, proposed,
                screened, oracle, oracle_lost, merged, wrong, sent_pct());
  }
};

constexpr const char* bins[] = {"o30", "o18", "o10", "o05", "apart_paths", "none"};

void write_csv(const std::vector<PairRow>& rows, const std::filesystem::path& file) {
  std::ofstream csv(file);
  csv << "set,a,b,overlap_pct,nearest_m,bin,source,rank,proposals,screened,oracle_p,oracle_status,merged,right,te_m,ms,"
         "clouds,clouds_sent,"
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
        << ',' << r.te_m << ',' << r.ms << ',' << r.clouds << ',' << r.clouds_sent << ',' << found.probability << ','
        << r.found_te_m;
    for (const auto& field : evidence_fields()) csv << ',' << r.oracle.evidence.*field.member;
    for (const auto& field : evidence_fields()) csv << ',' << found.*field.member;
    csv << "\n";
  }
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
  std::printf("stages: %zu pairs of sessions\n  %-24s %5s %6s %8s %8s %6s %6s %6s %6s %8s\n", rows.size(), "", "pairs",
              "slides", "proposed", "screened", "oracle", "lost", "merged", "wrong", "clouds");
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

/// How far probabilities can be believed, beside the table and as verdict.json, with recall as the table counts it.
void report_verdict(const Calibration& calibration, const nlohmann::json& by_bin, const std::filesystem::path& out) {
  calibration.print();
  nlohmann::json figures = calibration.json();
  const auto share = [&](std::initializer_list<const char*> of) {
    double merged = 0, pairs = 0;
    for (const char* bin : of) {
      merged += by_bin.at(bin).at("merged").get<double>();
      pairs += by_bin.at(bin).at("pairs").get<double>();
    }
    return pairs > 0 ? merged / pairs : 0;
  };
  figures["recall_o18"] = share({"o18", "o30"});
  figures["recall_o10"] = share({"o10"});
  std::ofstream(out / "verdict.json") << nlohmann::json{{"verdict", figures}}.dump(1) << "\n";
  if (const auto drawn = calibration.draw(out / "reliability.png"); !drawn)
    std::fprintf(stderr, "headframe-bench: %s\n", drawn.error().message.c_str());
}

}  // namespace

nlohmann::json stages(const StagesBench& bench) {
  const auto sets = sets_below(bench.sets);
  std::vector<PairRow> rows;
  VerdictRows evidence(bench.out / "verdict_sets.csv");
  for (const auto& set : sets) {
    const auto truth = truth_of(set);
    const auto sessions = sessions_of(set, bench.families, bench.days_apart);
    for (const auto& pair : truth.at("pairs")) {
      const InCommon common{pair.at("overlap_pct"), pair.at("nearest_poses_m")};
      rows.push_back(study(sessions.at(pair.at("a")), sessions.at(pair.at("b")), common, bench.clouds, evidence));
      print_if_lost(rows.back());
    }
    std::fprintf(stderr, "\r%zu of %zu data sets", static_cast<std::size_t>(&set - sets.data()) + 1, sets.size());
  }
  std::fprintf(stderr, "\n");
  write_csv(rows, bench.out / "stages.csv");
  nlohmann::json figures = summed_up(rows);
  report_verdict(evidence.calibration(), figures, bench.out);
  return figures;
}

nlohmann::json stages_crossed(const StagesBench& bench) {
  std::map<std::string, std::vector<DrivenSession>> by_kind;
  double later_s = 0;  // sets follow each other as robots do
  for (const auto& set : sets_below(bench.sets)) {
    const auto of_set = sessions_of(set, bench.families, bench.days_apart);
    for (const auto& [robot, session] : of_set) {
      by_kind[kind_of(session.world)].push_back(session);
      for (Keyframe& keyframe : by_kind[kind_of(session.world)].back().keyframes) keyframe.stamp_s += later_s;
    }
    later_s += bench.days_apart * 86400 * static_cast<double>(of_set.size());
  }
  std::vector<PairRow> rows;
  VerdictRows evidence(bench.out / "verdict_crossed.csv");
  for (auto& [kind, sessions] : by_kind) {
    std::vector<std::string> sets;
    for (DrivenSession& session : sessions) sets.push_back(std::exchange(session.world, kind));
    for (std::size_t i = 0; i < sessions.size(); ++i)
      for (std::size_t j = i + 1; j < sessions.size(); ++j) {
        if (sets[i] == sets[j]) continue;
        rows.push_back(
            study(sessions[i], sessions[j], path_in_common(sessions[i], sessions[j]), bench.clouds, evidence));
        print_if_lost(rows.back());
        std::fprintf(stderr, "\r%s: session %zu of %zu", kind.c_str(), i + 1, sessions.size());
      }
  }
  std::fprintf(stderr, "\n");
  write_csv(rows, bench.out / "stages_crossed.csv");
  return summed_up(rows);
}

}  // namespace headframe::bench
