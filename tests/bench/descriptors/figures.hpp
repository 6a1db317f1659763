#pragma once
// What the bench knows of one family, and what becomes of it: a table, JSON, pictures.

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/descriptor/family.hpp"
#include "tests/bench/descriptors/retrieval.hpp"

namespace headframe::bench {

constexpr int shift_step_deg = 15, shift_last_deg = 180;

/// Of 1701 x 2840 keyframes: wall time with two threads, processor time with one.
struct QueryTimes {
  double median_ms = -1, cpu_ms = -1;
};

/// Wall times of levelling and extraction on one thread, and the processor time of all threads it may have used.
struct ExtractTimes {
  double median_ms = -1, p95_ms = -1, cpu_ms = -1;
  std::size_t points = 0;  // of a scan, median
};

struct Row {
  std::string name;  // as in the JSON
  Answers answers = {};
};

struct FamilyFigures {
  std::string name;
  std::unique_ptr<DescriptorFamily> family;
  std::vector<Row> rows = {};  // in the order they are shown
  /// Of the rows `same` and `cross`: the query turned by 0, 15, ... 180 deg.
  std::map<std::string, std::vector<Answers>> by_shift = {};
  ClassCount junctions = {};
  bool tells_class = false;
  std::size_t bytes = 0;  // of q and w of a keyframe
  ExtractTimes extract = {};
  QueryTimes query_all = {};                                               // of q as it is in a mine
  QueryTimes query_all_whole = {};                                         // ... and where no number of it is zero
  std::vector<std::pair<std::string, std::size_t>> hypothesis_ranks = {};  // of the right one by pair; 0: not handed on

  void add(const std::string& row, const Answers& answers);
  const Answers* row(const std::string& row_name) const;  // null: not measured
};

void print_tables(const std::vector<FamilyFigures>& families);
nlohmann::json to_json(const FamilyFigures& figures);

/// recall_over_n.png, recall_over_yaw_shift.png and precision_over_recall.png, one line a family. Fails (unavailable)
/// when a file cannot be written.
Result<void> draw_pictures(const std::vector<FamilyFigures>& families, const std::filesystem::path& folder);

}  // namespace headframe::bench
