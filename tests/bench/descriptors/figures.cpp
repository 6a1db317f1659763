#include "tests/bench/descriptors/figures.hpp"

#include <algorithm>

#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

nlohmann::json yaw_json(const Answers& answers) {
  const auto errors = yaw_errors_deg(answers);
  if (errors.empty()) return nullptr;
  return {{"p50_deg", quantile(errors, 0.5)},
          {"p95_deg", quantile(errors, 0.95)},
          {"top2_within_10deg", share_top2_within_10deg(answers)}};
}

/// Own mines, same sensor and across.
Answers headline(const FamilyFigures& figures) {
  Answers all;
  for (const char* name : {"same", "cross"})
    if (const Answers* answers = figures.row(name)) all.insert(all.end(), answers->begin(), answers->end());
  return all;
}

}  // namespace

void FamilyFigures::add(const std::string& row_name, const Answers& answers) {
  auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.name == row_name; });
  if (found == rows.end()) found = rows.insert(rows.end(), {row_name});
  found->answers.insert(found->answers.end(), answers.begin(), answers.end());
}

const Answers* FamilyFigures::row(const std::string& row_name) const {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.name == row_name; });
  return found == rows.end() ? nullptr : &found->answers;
}

nlohmann::json to_json(const FamilyFigures& f) {
  nlohmann::json out{{"bytes", f.bytes},
                     {"extract_ms", f.extract.median_ms},
                     {"extract_p95_ms", f.extract.p95_ms},
                     {"extract_cpu_ms", f.extract.cpu_ms},
                     {"extract_points", f.extract.points},
                     {"query_all_ms", f.query_all.median_ms},
                     {"query_all_cpu_ms", f.query_all.cpu_ms},
                     {"query_all_whole_q_ms", f.query_all_whole.median_ms}};
  for (const Row& row : f.rows) {
    out["queries"][row.name] = count_queries(row.answers);
    for (const std::size_t n : {1U, 5U, 20U}) out["recall" + std::to_string(n)][row.name] = recall(row.answers, n);
    out["precision_at_full_recall"][row.name] = precision_at_full_recall(row.answers);
    if (auto yaw = yaw_json(row.answers); !yaw.is_null()) out["yaw"][row.name] = std::move(yaw);
  }
  if (const auto yaw = yaw_json(headline(f)); !yaw.is_null())
    for (const auto& [key, value] : yaw.items()) out["yaw_" + key] = value;
  for (const auto& [row, shifts] : f.by_shift)
    for (const Answers& answers : shifts) out["recall1_by_yaw_shift"][row].push_back(recall(answers, 1));
  for (const auto& [pair, rank] : f.hypothesis_ranks) out["hypothesis_rank"][pair] = rank;
  if (f.tells_class) out["junction_f1"] = f.junctions.f1();
  return out;
}

}  // namespace headframe::bench
