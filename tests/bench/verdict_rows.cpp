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

VerdictRows::VerdictRows(const std::filesystem::path& file) : csv_(file) {
  csv_ << "source,kind,mine,a,b,right,status";
  for (const auto& field : evidence_fields()) csv_ << ',' << field.name;
  for (const auto& term : verdict_terms({})) csv_ << ",term: " << term.name;
  csv_ << ",by hand,told";
  csv_ << '\n';
}

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
  csv_ << source << ',' << kind << ',' << a.world << ',' << a.name << ',' << b.name << ',' << right << ','
       << to_string(judged.status);
  for (const auto& field : evidence_fields()) csv_ << ',' << judged.evidence.*field.member;
  Evidence unique = judged.evidence;
  unique.aliases = unique.repetition = unique.look_alikes = 0;
  for (const auto& term : verdict_terms(unique)) csv_ << ',' << term.value;
  csv_ << ',' << log_odds(unique).taken_as_given() << ',' << calibrated(judged.evidence, {});
  csv_ << '\n' << std::flush;
}

}  // namespace headframe::bench
