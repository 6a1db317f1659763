#pragma once
// Labelled evidence, one row for each placement that was judged: what a verdict is fitted on.

#include <fstream>
#include <string>

#include "tests/bench/calibration.hpp"
#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {

/// Which placement a row tells of.
struct RowName {
  std::string source, kind, mine, a, b;
  bool right = false;
};

/// The names of the columns, and one row: evidence, the verdict's terms, and what this build makes of them.
void write_row_head(std::ostream& csv);
void write_row(std::ostream& csv, const RowName& name, RegistrationStatus status, const Evidence& evidence);

/// Writes world kind, mine, both sessions, label and every term as CSV. A placement is right within 1 m and 3 deg of
/// the truth near the overlap, wrong from 2 m or 5 deg on; what lies between has no row.
class VerdictRows {
 public:
  explicit VerdictRows(const std::filesystem::path& file);

  /// All placements that the run's attempts judged.
  void add(const PipelineRun& run);
  /// The verdict on the true placement.
  void add_oracle(const DrivenSession& a, const DrivenSession& b, const Judgement& judged);

  /// Of the placements that attempts judged.
  const Calibration& calibration() const { return calibration_; }

 private:
  void write(const char* source, const DrivenSession& a, const DrivenSession& b, bool right, const Judgement& judged);
  std::ofstream csv_;
  Calibration calibration_;
};

}  // namespace headframe::bench
