#include "server/atlas/findings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/verification/verdict.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

Finding finding(Evidence e, std::string_view term) {
  e.probability = probability(RegistrationStatus::converged, e);
  const auto found = findings_of(e);
  const auto at = std::find_if(found.begin(), found.end(), [&](const Finding& f) { return f.evidence == term; });
  EXPECT_NE(at, found.end()) << term;
  return at == found.end() ? Finding{} : *at;
}

TEST(Findings, EveryTermIsSaidOnceTheStrongestAgainstFirst) {
  Evidence e = test::convincing();
  e.look_alikes = 6;
  e.descriptors_alike = 0.7;
  const auto found = findings_of(e);
  EXPECT_EQ(found.size(), verdict_term_count);
  EXPECT_EQ(found.front().evidence, "descriptors differ over little path");
  for (std::size_t i = 1; i < found.size() && found[i].speaks == Speaks::against; ++i)
    EXPECT_LE(found[i - 1].log_odds, found[i].log_odds);
  for (const Finding& f : found) EXPECT_FALSE(f.text.empty());
}

TEST(Findings, WhatAloneWouldSufficeIsSaid) {
  Evidence e = test::convincing();
  e.look_alikes = 12;
  e.overlap_m = 25;
  e.rock_in_common = 850;
  e.support = 200;
  const Finding alike = finding(e, "places look alike");
  EXPECT_NE(alike.text.find("at 12.0 other placements"), std::string::npos) << alike.text;
  EXPECT_NE(alike.would_suffice.find("look-alikes at most would suffice"), std::string::npos);
  e.overlap_m = 20;
  const Finding path = finding(e, "path that is shared");
  EXPECT_NE(path.would_suffice.find("m of path in common would suffice"), std::string::npos) << path.would_suffice;
}

TEST(Findings, WhatIsNotKnownIsSaidToBeSo) {
  Evidence e = test::convincing();
  e.support = e.descriptors_compared = e.rock_in_common = 0;
  EXPECT_NE(finding(e, "walls match").text.find("came from no search"), std::string::npos);
  EXPECT_EQ(finding(e, "walls match").log_odds, 0);
  EXPECT_NE(finding(e, "places are similar").text.find("is not known"), std::string::npos);
  EXPECT_NE(finding(e, "descriptors agree").text.find("say nothing"), std::string::npos);
  EXPECT_NE(finding(e, "rock that both saw").text.find("is not known"), std::string::npos);
  EXPECT_EQ(finding(e, "rock that both saw").log_odds, 0);
}

}  // namespace
}  // namespace headframe
