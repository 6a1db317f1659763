#include "tests/bench/verdict_rows.hpp"

#include <optional>

#include "server/verification/verdict.hpp"

namespace headframe::bench {
namespace {

std::optional<bool> label(const DrivenSession& a, const DrivenSession& b, const Pose& T_a_b) {
  if (a.world != b.world) return false;
  const test::OverlapError error = nearest_overlap_error(a.path, b.path, T_a_b);
  if (error.pairs == 0 || error.translation_m > 2 || error.rotation_deg > 5) return false;
  if (error.translation_m < 1 && error.rotation_deg < 3) return true;
  return std::nullopt;
}

}  // namespace

void write_row_head(std::ostream& csv) {
  csv << "source,kind,mine,a,b,right,status";
  for (const auto& field : evidence_fields()) csv << ',' << field.name;
  for (const auto& term : verdict_measures({})) csv << ",term: " << term.name;
  csv << ",told\n";
}

void write_row(std::ostream& csv, const RowName& name, RegistrationStatus status, const Evidence& evidence) {
  csv << name.source << ',' << name.kind << ',' << name.mine << ',' << name.a << ',' << name.b << ',' << name.right
      << ',' << to_string(status);
  for (const auto& field : evidence_fields()) csv << ',' << evidence.*field.member;
  for (const auto& term : verdict_measures(evidence)) csv << ',' << term.value;
  csv << ',' << calibrated(evidence, {}) << '\n' << std::flush;
}

VerdictRows::VerdictRows(const std::filesystem::path& file) : csv_(file) { write_row_head(csv_); }

void VerdictRows::add(const PipelineRun& run) {
  for (const PairTrace& trace : run.traces)
    for (const Judgement& judged : trace.judged) {
      const DrivenSession &a = run.session(trace.a), &b = run.session(trace.b);
      const auto right = label(a, b, judged.T_a_b);
      if (!right) continue;
      write("judged", a, b, *right, judged);
      calibration_.add(calibrated(judged.evidence, {}), *right, a.world);
    }
}

void VerdictRows::add_oracle(const DrivenSession& a, const DrivenSession& b, const Judgement& judged) {
  if (label(a, b, judged.T_a_b).value_or(false)) write("oracle", a, b, true, judged);
}

void VerdictRows::write(const char* source, const DrivenSession& a, const DrivenSession& b, bool right,
                        const Judgement& judged) {
  const std::string kind = a.world.substr(0, a.world.find('-'));
  write_row(csv_, {source, kind, a.world, a.name, b.name, right}, judged.status, judged.evidence);
}

}  // namespace headframe::bench
