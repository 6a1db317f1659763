#include "tests/bench/rejudge.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "server/verification/verdict.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe::bench {
namespace {

/// Accepted whatever its recorded probability was: long, held from all sides, contradicted by nothing.
Evidence convincing() {
  Evidence e;
  e.pairs = 20, e.places = e.places_agreeing = 6;
  e.inlier_fraction = 0.8, e.matched_share = 0.9, e.rmse_m = 0.08, e.residual_m = 0.03, e.spread_m = 0.05;
  e.overlap_m = 80, e.weakest_hold = 0.2, e.end_on_match = 0.5, e.descriptors_compared = 15, e.descriptors_alike = 0.95;
  return e;
}

struct Rows {
  TempDir folder;
  std::filesystem::path file = folder.path() / "verdict.csv";
  std::filesystem::path anew = folder.path() / "rejudged.csv";
  std::ofstream csv{file};

  Rows() {
    csv << "source,kind,mine,a,b,right,status";
    for (const auto& field : evidence_fields()) csv << ',' << field.name;
    csv << '\n';
  }
  void add(const char* source, const char* kind, bool right, const Evidence& e, const char* status = "converged") {
    csv << source << ',' << kind << ',' << kind << "-1,a,b," << right << ',' << status;
    for (const auto& field : evidence_fields()) csv << ',' << e.*field.member;
    csv << '\n' << std::flush;
  }
};

TEST(Rejudge, CountsWhatIsAcceptedNowAndWasBefore) {
  Rows rows;
  Evidence e = convincing();
  ASSERT_GT(probability(RegistrationStatus::converged, e), 0.9);
  e.probability = 0.1;
  rows.add("judged", "cave", true, e);
  rows.add("judged", "cave", true, e, "degenerate");
  rows.add("oracle", "cave", true, e);  // only what attempts found is counted
  e.probability = 0.95, e.freespace_violation = e.worst_place_violation = 0.1;
  rows.add("judged", "rough", false, e);
  const nlohmann::json figures = rejudge({rows.file, rows.file}, rows.anew);
  EXPECT_EQ(figures.at("cave"), (nlohmann::json{{"right", 4},
                                                {"wrong", 0},
                                                {"accepted_right", 2},
                                                {"accepted_wrong", 0},
                                                {"before_right", 0},
                                                {"before_wrong", 0}}));
  EXPECT_EQ(figures.at("all").at("before_wrong"), 2);
  EXPECT_EQ(figures.at("all").at("accepted_wrong"), 0);
}

TEST(Rejudge, ARunnerUpHoldsAPlacementBack) {
  Rows rows;
  Evidence e = convincing();
  e.probability = 0.95, e.runner_up = 0.9999;
  rows.add("judged", "cave", true, e);
  EXPECT_EQ(rejudge({rows.file}, rows.anew).at("all").at("accepted_right"), 0);
}

std::string refusal(const std::filesystem::path& file) {
  try {
    rejudge({file}, "/dev/null");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Rejudge, WhatItWritesIsJudgedAlike) {
  Rows rows;
  Evidence e = convincing();
  e.probability = 0.1;
  rows.add("judged", "cave", true, e);
  rejudge({rows.file}, rows.anew);
  const nlohmann::json again = rejudge({rows.anew}, rows.anew);  // which is read before it is written over
  EXPECT_EQ(again.at("cave").at("before_right"), 1) << "with the probability of this build";
  EXPECT_EQ(again.at("cave").at("accepted_right"), 1);
}

TEST(Rejudge, RowsThatCannotBeWrittenAreSaid) {
  Rows rows;
  rows.add("judged", "cave", true, convincing());
  EXPECT_THROW(rejudge({rows.file}, "/dev/full"), std::runtime_error);
}

TEST(Rejudge, RefusesWhatIsNoSuchFile) {
  Rows rows;
  std::ofstream(rows.folder.path() / "other.csv") << "set,a,b\n";
  EXPECT_NE(refusal(rows.folder.path() / "other.csv").find("no column source"), std::string::npos);
  EXPECT_NE(refusal(rows.folder.path() / "missing.csv").find("cannot be read"), std::string::npos);
}

TEST(Rejudge, RefusesADamagedLineByItsNumber) {
  Rows cut;
  cut.csv << "judged,cave,cave-1,a\n" << std::flush;
  EXPECT_NE(refusal(cut.file).find("line 2 (it is cut short)"), std::string::npos);

  Rows rows;
  rows.add("judged", "cave", true, convincing());
  EXPECT_EQ(refusal(rows.file), "");
  std::filesystem::resize_file(rows.file, std::filesystem::file_size(rows.file) - 1);
  EXPECT_NE(refusal(rows.file).find("line 2 (it is cut short)"), std::string::npos) << "in its last cell";

  Rows garbled;
  garbled.csv << "judged,cave,cave-1,a,b,1,converged";
  for (std::size_t i = 0; i < evidence_fields().size(); ++i) garbled.csv << (i == 3 ? ",0.5x" : ",0.5");
  garbled.csv << std::endl;
  EXPECT_NE(refusal(garbled.file).find("line 2 ('0.5x' is no number)"), std::string::npos);
}

}  // namespace
}  // namespace headframe::bench
