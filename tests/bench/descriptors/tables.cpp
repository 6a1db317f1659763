#include <cstdio>

#include "tests/bench/descriptors/figures.hpp"
#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

void print_row(const std::string& family, const Row& row) {
  const auto errors = yaw_errors_deg(row.answers);
  std::printf("  %-16s %-22s %7zu  %.3f %.3f %.3f  %9.3f", family.c_str(), row.name.c_str(), count_queries(row.answers),
              recall(row.answers, 1), recall(row.answers, 5), recall(row.answers, 20),
              precision_at_full_recall(row.answers));
  if (errors.empty())
    std::printf("  %7s %7s %7s\n", "-", "-", "-");
  else
    std::printf("  %7.2f %7.2f %7.3f\n", quantile(errors, 0.5), quantile(errors, 0.95),
                share_top2_within_10deg(row.answers));
}

void print_costs(const FamilyFigures& f) {
  std::printf("  %-16s %6zu %8.2f %8.2f %8.2f %9zu %10.1f %8.1f", f.name.c_str(), f.bytes, f.extract.median_ms,
              f.extract.p95_ms, f.extract.cpu_ms, f.extract.points, f.query_all.median_ms, f.query_all.cpu_ms);
  if (f.tells_class)
    std::printf(" %12.3f\n", f.junctions.f1());
  else
    std::printf(" %12s\n", "-");
}

void print_shifts(const FamilyFigures& f) {
  for (const auto& [row, shifts] : f.by_shift) {
    std::printf("  %-16s %-8s", f.name.c_str(), row.c_str());
    for (const Answers& answers : shifts) std::printf(" %5.3f", recall(answers, 1));
    std::printf("\n");
  }
}

void print_ranks(const FamilyFigures& f) {
  std::printf("  %-16s", f.name.c_str());
  for (const auto& [pair, rank] : f.hypothesis_ranks)
    std::printf("  %s: %s", pair.c_str(), rank == 0 ? "none" : std::to_string(rank).c_str());
  std::printf("\n");
}

}  // namespace

void print_tables(const std::vector<FamilyFigures>& families) {
  std::printf("  %-16s %-22s %7s  %5s %5s %5s  %9s  %7s %7s %7s\n", "family", "row", "queries", "r@1", "r@5", "r@20",
              "precision", "yaw p50", "p95 deg", "top2");
  for (std::size_t i = 0; i < families.front().rows.size(); ++i)
    for (const FamilyFigures& f : families) print_row(f.name, f.rows[i]);
  std::printf("\n  %-16s %6s %8s %8s %8s %9s %10s %8s %12s\n", "family", "bytes", "ms/scan", "p95 ms", "cpu ms",
              "points", "all:all ms", "cpu ms", "junction F1");
  for (const FamilyFigures& f : families) print_costs(f);
  std::printf("\n  recall@1 with the query turned by 0, %d, ... %d deg\n", shift_step_deg, shift_last_deg);
  for (const FamilyFigures& f : families) print_shifts(f);
  if (families.front().hypothesis_ranks.empty()) return;
  std::printf("\n  rank of the right hypothesis among those handed on to registration\n");
  for (const FamilyFigures& f : families) print_ranks(f);
}

}  // namespace headframe::bench
