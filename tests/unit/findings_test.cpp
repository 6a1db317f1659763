#include "server/atlas/findings.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "server/verification/verdict.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

/// Where places look alike and the walls hold the placement loosely.
Finding first_finding(double descriptors_compared) {
  Evidence e = test::convincing();
  e.look_alikes = 3;
  e.weakest_hold = 0.05;
  e.descriptors_compared = descriptors_compared;
  e.descriptors_alike = descriptors_compared > 0 ? 0.9 : 0;
  e.probability = probability(RegistrationStatus::converged, e);
  EXPECT_LT(e.probability, VerdictThresholds{}.accept_probability);
  return findings_of(e).front();
}

TEST(Findings, WithoutDescriptorsMorePathWouldTellPlacesThatLookAlikeApart) {
  const Finding f = first_finding(0);
  EXPECT_EQ(f.evidence, "descriptors hardly tell it from another place");
  EXPECT_NE(f.text.find("no two keyframes of one known descriptor family"), std::string::npos) << f.text;
  EXPECT_NE(f.text.find("36 m of path are shared"), std::string::npos) << f.text;
  EXPECT_NE(f.would_suffice.find("m of path in common would suffice"), std::string::npos) << f.would_suffice;
}

TEST(Findings, WithoutDescriptorsPlacesThatLieApartAreSaid) {
  Evidence e = test::convincing();
  e.places = e.places_agreeing = 3;
  e.overlap_m = 5.9;
  e.weakest_hold = 0.071;
  e.spread_m = 0.24;
  e.probability = probability(RegistrationStatus::converged, e);
  ASSERT_LT(e.probability, VerdictThresholds{}.accept_probability);
  const Finding f = findings_of(e).front();
  EXPECT_EQ(f.evidence, "descriptors hardly tell it from another place");
  EXPECT_NE(f.text.find("or lie apart (by 0.24 m)"), std::string::npos) << f.text;
}

TEST(Findings, WallsThatMatchFartherOffAreSaid) {
  Evidence e = test::convincing();
  e.overlap_m = 7;
  e.support = 140;
  const auto found = findings_of(e);
  const auto walls = std::find_if(found.begin(), found.end(),
                                  [](const Finding& f) { return f.evidence == "walls farther off match"; });
  ASSERT_NE(walls, found.end());
  EXPECT_GT(walls->log_odds, 0);
  EXPECT_NE(walls->text.find("match with a score of 140"), std::string::npos) << walls->text;
}

TEST(Findings, ThatLittleTellsAShortOverlapFromACopySaysWhatWouldSuffice) {
  Evidence e = test::convincing();
  e.overlap_m = 13;
  e.support = 110;
  e.rmse_m = 0.11;
  Finding f = findings_of(e).front();
  EXPECT_EQ(f.evidence, "little tells a short overlap from a copy");
  EXPECT_LT(f.log_odds, 0);
  EXPECT_NE(f.text.find("13 m of path are shared, the walls"), std::string::npos) << f.text;
  EXPECT_NE(f.text.find("a score of 110, points scatter by 110 mm, no two"), std::string::npos) << f.text;
  EXPECT_EQ(f.would_suffice.rfind("a score of 1", 0), 0U) << f.would_suffice;
  e.descriptors_compared = 3;
  e.descriptors_alike = 0.7;
  f = findings_of(e).front();
  EXPECT_EQ(f.evidence, "little tells a short overlap from a copy");
  EXPECT_NE(f.would_suffice.find("% alike would suffice"), std::string::npos) << f.would_suffice;
}

TEST(Findings, WithDescriptorsOnesThatAgreeWould) {
  const Finding f = first_finding(8);
  EXPECT_EQ(f.evidence, "descriptors hardly tell it from another place");
  EXPECT_EQ(f.text.find("m of path are shared"), std::string::npos) << f.text;
  EXPECT_NE(f.would_suffice.find("% alike would suffice"), std::string::npos) << f.would_suffice;
}

}  // namespace
}  // namespace headframe
