#include "tests/bench/pair_study.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "tests/bench/made_sets.hpp"
#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

constexpr double right_m = 4, right_deg = 15;   // within the reach of a registration
constexpr double merged_m = 1, merged_deg = 3;  // of a merge, near the overlap
constexpr double apart_m = 10;                  // trajectories that never come nearer do not overlap

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

  PairRow run(Clouds clouds, VerdictRows& rows) {
    PipelineRun run(clouds);
    run.add(a_);
    run.take_as_tried();
    run.add(b_);
    row_.ms = wall_ms([&] { row_.times = run.attempt(2); });
    row_.ms -= row_.times.loop_closures_ms;  // after the merge was told
    row_.clouds = a_.clouds.size() + b_.clouds.size();
    row_.clouds_sent = clouds == Clouds::at_once ? row_.clouds : run.came();
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
      row_.found_te_m = near_each_other() ? overlap_error(a_.path, b_.path, k.T_a_b, near_m_).translation_m : -1;
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
  bool near_each_other() const { return near_m_ < 60; }
  bool overlaps() const { return row_.overlap_pct >= 1 && near_each_other(); }
  bool near(const Pose& T_a_b, double metres, double degrees) const {
    if (!near_each_other()) return false;
    const auto error = overlap_error(a_.path, b_.path, T_a_b, near_m_);
    return error.pairs > 0 && error.translation_m < metres && error.rotation_deg < degrees;
  }

  const DrivenSession &a_, &b_;
  double near_m_ = 8;
  PairRow row_;
};

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

}  // namespace

PairRow study(const DrivenSession& a, const DrivenSession& b, const InCommon& truth, Clouds clouds, VerdictRows& rows) {
  return PairStudy(a, b, truth).run(clouds, rows);
}

bool degenerate(const PairRow& r) { return r.oracle.status == RegistrationStatus::degenerate; }

const char* bin_of(const PairRow& r) {
  if (r.overlap_pct < 5) return "none";
  if (r.nearest_m >= apart_m) return "apart_paths";
  if (r.overlap_pct >= 30) return "o30";
  if (r.overlap_pct >= 18) return "o18";
  return r.overlap_pct >= 10 ? "o10" : "o05";
}

void print_if_lost(const PairRow& row) {
  if (!row.right && (row.overlap_pct >= 1 || row.merged)) print_lost(row);
}

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

}  // namespace headframe::bench
