#include "server/atlas/explain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/verification/verdict.hpp"

namespace headframe {
namespace {

ExplainedSession session(const std::string& name) { return {name, {"scan_context", 1}, 200, 60, 60, true, true}; }

/// A placement that nothing speaks against.
Alignment good() {
  Alignment k{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {10, 20, 1}), {}};
  k.verdict = AlignmentState::verified;
  Evidence& e = k.evidence;
  e.probability = 0.98;
  e.pairs = 12;
  e.places = e.places_agreeing = 5;
  e.inlier_fraction = 0.9;
  e.rmse_m = 0.05;
  e.own_scatter_m = 0.035;
  e.overlap_a = 0.6;
  e.overlap_b = 0.5;
  e.seen_points = 20000;
  e.residual_m = 0.03;
  e.overlap_m = 50;
  e.weakest_hold = 0.1;
  e.end_on_match = 0.5;
  e.descriptors_compared = 8;
  e.descriptors_alike = 0.88;
  e.support = 400;
  e.tilt_deg = 0.2;
  return k;
}

std::string name(SessionId id) { return "robot/" + std::to_string(id); }

Explanation explained(const Alignment& k, bool together = false) {
  return explain(session("ant/1"), session("bee/1"), &k, together, {}, name);
}

bool says(const std::vector<std::string>& lines, const std::string& what) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& l) { return l.find(what) != std::string::npos; });
}

std::optional<Speaks> side(const Explanation& e, std::string_view evidence) {
  const auto at =
      std::find_if(e.findings.begin(), e.findings.end(), [&](const auto& f) { return f.evidence == evidence; });
  return at == e.findings.end() ? std::nullopt : std::optional(at->speaks);
}

TEST(Explain, WhatIsContradictedFartherOffSpeaksAgainst) {
  Alignment k = good();
  EXPECT_EQ(side(explained(k), "free space farther off contradicts"), Speaks::in_favour);
  k.evidence.farther_violation = 0.01;
  EXPECT_EQ(side(explained(k), "free space farther off contradicts"), Speaks::against);
}

TEST(Explain, WhatOnlyLikenessSpeaksAgainstIsForTheOperatorToDecide) {
  Alignment k = good();
  k.state = AlignmentState::candidate;
  k.evidence.look_alikes = 6;
  k.evidence.probability = 0.33;
  k.evidence.probability_if_unique = 0.9;
  EXPECT_TRUE(says(explained(k).missing, "nothing but its likeness to other places speaks against it"));
  k.evidence.probability_if_unique = 0.89;
  EXPECT_FALSE(says(explained(k).missing, "nothing but its likeness"));
  k.evidence.probability = k.evidence.probability_if_unique = 0.95;
  EXPECT_FALSE(says(explained(k).missing, "nothing but its likeness")) << "it convinces";
}

TEST(Explain, FindingsAreTheVerdictItself) {
  Alignment k = good();
  k.evidence.worst_place_violation = 0.01;
  k.evidence.overlap_m = 12;
  const std::vector<Finding> findings = explained(k).findings;
  const LogOdds odds = log_odds(k.evidence);
  double sum = odds.bias;
  for (const Finding& f : findings) sum += f.log_odds;
  EXPECT_NEAR(sum, odds.sum(), 1e-9) << "none is left out, none added";
  for (std::size_t i = 1; i < findings.size(); ++i) {
    EXPECT_LE(findings[i - 1].speaks == Speaks::in_favour, findings[i].speaks == Speaks::in_favour);
    if (findings[i].speaks == Speaks::against) {
      EXPECT_LE(findings[i - 1].log_odds, findings[i].log_odds);
    }
  }
  EXPECT_EQ(findings.front().evidence, "free space contradicts");
  Evidence without = k.evidence;
  without.worst_place_violation = 0;
  without.probability = 1 / (1 + std::exp(-log_odds(without).sum()));
  const VerdictThresholds thresholds;
  EXPECT_NEAR(probability_without(findings.front(), k.evidence, thresholds), calibrated(without, thresholds), 1e-9);
}

TEST(Explain, AFigureThatWouldSufficeDoesAndOneABitWorseDoesNot) {
  struct Case {
    double Evidence::*member;
    double bad, worse;  // worse: by how much of itself
    std::string_view term;
  };
  for (const Case& c : {Case{&Evidence::worst_place_violation, 0.05, 1.02, "free space contradicts"},
                        Case{&Evidence::descriptors_alike, 0.1, 0.98, "descriptors agree"},
                        Case{&Evidence::spread_m, 4, 1.02, "places lie apart"}}) {
    Alignment k = good();
    k.state = AlignmentState::candidate;
    k.evidence.overlap_m = 40;
    k.evidence.support = 320;
    k.evidence.*c.member = c.bad;
    k.evidence.probability = probability(RegistrationStatus::converged, k.evidence);
    ASSERT_LT(k.evidence.probability, VerdictThresholds{}.accept_probability) << c.term;
    const Explanation e = explained(k);
    const auto f =
        std::find_if(e.findings.begin(), e.findings.end(), [&](const auto& g) { return g.evidence == c.term; });
    ASSERT_TRUE(f != e.findings.end() && f->sufficient) << c.term;
    EXPECT_FALSE(f->would_suffice.empty());
    k.evidence.*c.member = *f->sufficient;
    EXPECT_GE(probability(RegistrationStatus::converged, k.evidence), VerdictThresholds{}.accept_probability - 1e-6);
    k.evidence.*c.member *= c.worse;
    EXPECT_LT(probability(RegistrationStatus::converged, k.evidence), VerdictThresholds{}.accept_probability) << c.term;
  }
}

TEST(Explain, WhereNothingAloneWouldSufficeNothingIsSaidToDoSo) {
  Alignment k = good();
  k.evidence.worst_place_violation = 0.2;
  k.evidence.spread_m = 6;
  for (const Finding& f : explained(k).findings) EXPECT_TRUE(f.would_suffice.empty()) << f.text;
  for (const Finding& f : explained(good()).findings) EXPECT_FALSE(f.sufficient) << "it is believed already";
}

TEST(Explain, WhatChangesExcuseDoesNotWeighAndIsNamed) {
  Alignment k = good();
  k.evidence.freespace_violation = k.evidence.freespace_explained = 0.012;
  k.evidence.worst_place_violation = k.evidence.worst_place_explained = 0.03;
  const Explanation e = explained(k);
  const auto free = std::find_if(e.findings.begin(), e.findings.end(),
                                 [](const auto& f) { return f.evidence == "free space contradicts"; });
  ASSERT_TRUE(free != e.findings.end());
  EXPECT_EQ(free->speaks, Speaks::in_favour);
  EXPECT_NE(free->text.find("0.00 % of the points"), std::string::npos) << free->text;
  EXPECT_NE(free->text.find("besides 3.00 % where the mine has changed"), std::string::npos) << free->text;
}

TEST(Explain, GatesAreShownAsGates) {
  const auto failed = [](const Alignment& k) {
    std::vector<std::string> names;
    for (const Gate& gate : explained(k).gates)
      if (!gate.passed) names.emplace_back(gate.name);
    return names;
  };
  using Names = std::vector<std::string>;
  Alignment k = good();
  k.evidence.probability = probability(RegistrationStatus::converged, k.evidence);
  EXPECT_EQ(failed(k), Names{});
  Alignment slides = k;
  slides.evidence.probability = probability(RegistrationStatus::degenerate, k.evidence);
  EXPECT_EQ(failed(slides), (Names{"held", "probable"}));
  Alignment leans = k;
  leans.evidence.tilt_deg = 3.1;
  leans.evidence.probability = 0;
  EXPECT_EQ(failed(leans), (Names{"upright", "probable", "told from its runner-up"}));
  Alignment rivalled = k;
  rivalled.evidence.runner_up = k.evidence.probability;
  EXPECT_EQ(failed(rivalled), Names{"told from its runner-up"});
  Alignment waits = k;
  waits.evidence.awaited_m = 30;
  EXPECT_EQ(failed(waits), Names{"path that is awaited"});
  Alignment contradicted = k;
  contradicted.objection = Objection{2, 7, 0.09};
  EXPECT_EQ(failed(contradicted), Names{"other sessions"});
}

TEST(Explain, AMergeSaysWhereAndHowSureAndMissesNothing) {
  const Explanation e = explained(good(), true);
  EXPECT_EQ(e.outcome,
            "ant/1 and bee/1 are merged: at x 10.0, y 20.0, z 1.0 m, turned by 28.6 deg, with probability 0.980");
  EXPECT_TRUE(e.missing.empty());
  EXPECT_TRUE(e.decision.empty());
  for (const Finding& f : e.findings) EXPECT_NE(f.speaks, Speaks::against) << f.text;
}

TEST(Explain, AMineThatRepeatsItselfAsksForMorePathTogether) {
  Alignment k = good();
  k.state = k.verdict = AlignmentState::candidate;
  k.evidence.probability = 0.8;
  EXPECT_FALSE(says(explained(k).missing, "drive further together"));
  k.evidence.aliases = 2;
  EXPECT_TRUE(says(explained(k).missing, "drive further together"));
  EXPECT_TRUE(says(explained(k).missing, "2.0 other placements pass every test"));
}

TEST(Explain, WhoHoldsAMergeBackIsNamed) {
  Alignment k = good();
  k.state = AlignmentState::verified;
  EXPECT_NE(explained(k).outcome.find("contradicts stronger alignments"), std::string::npos);
  k.objection = {2, 7, 0.094};
  const Explanation e = explained(k);
  EXPECT_NE(e.outcome.find("other sessions contradict it"), std::string::npos);
  EXPECT_TRUE(says(e.missing, "lay robot/2 and robot/7 on each other")) << e.missing.front();
  EXPECT_TRUE(says(e.missing, "9.4 %"));
}

/// Each figure of the evidence on its bad side: it speaks against, and what it costs is said.
TEST(Explain, EachPieceOfEvidenceHasTwoSides) {
  struct Case {
    double Evidence::*member;
    double bad;
    std::string_view term;
    const char* missing;
  };
  for (const Case& c : {Case{&Evidence::worst_place_violation, 0.01, "free space contradicts", "1.00 % of the points"},
                        Case{&Evidence::rmse_m, 0.16, "points scatter about the surfaces", "160 mm off"},
                        Case{&Evidence::places_agreeing, 2, "places disagree", "2 of 5 places"},
                        Case{&Evidence::weakest_hold, 0.01, "walls hold it", "drive on to a junction"},
                        Case{&Evidence::look_alikes, 5, "places look alike", "at 5.0 other placements"},
                        Case{&Evidence::descriptors_alike, 0.5, "descriptors agree", "50 % alike"}}) {
    Alignment k = good();
    k.state = AlignmentState::candidate;
    k.evidence.probability = 0.5;
    EXPECT_NE(side(explained(k), c.term), Speaks::against) << c.term;
    EXPECT_FALSE(says(explained(k).missing, c.missing)) << c.missing;
    k.evidence.*c.member = c.bad;
    EXPECT_EQ(side(explained(k), c.term), Speaks::against) << c.term;
    EXPECT_TRUE(says(explained(k).missing, c.missing)) << c.missing;
  }
}

TEST(Explain, WhatTheVerdictAsksForIsNamedWithBothFigures) {
  Alignment k = good();
  k.state = AlignmentState::candidate;
  EXPECT_TRUE(explained(k).missing.empty());
  EXPECT_NE(explained(k).outcome.find("looks right, and waits"), std::string::npos);
  k.evidence.probability = 0.85;
  k.evidence.runner_up = 0.8;
  const Explanation e = explained(k);
  EXPECT_TRUE(says(e.missing, "the probability is 0.850 and must be 0.90"));
  EXPECT_TRUE(
      says(e.missing, "a different placement is nearly as good (its odds are 0.71 of this one's, must be below 0.10)"));
  EXPECT_NE(e.outcome.find("not sure enough"), std::string::npos);
}

TEST(Explain, SessionsSayWhatTheyLack) {
  ExplainedSession brief = session("ant/1"), away = session("bee/1");
  brief.path_m = 31;
  brief.complete = false;
  away.clouds = 3;
  away.connected = false;
  Alignment k = good();
  k.state = AlignmentState::candidate;
  const auto missing = explain(brief, away, &k, false, {}, name).missing;
  EXPECT_TRUE(says(missing, "ant/1 is too short: 31 of 50 m")) << missing.size();
  EXPECT_TRUE(says(missing, "bee/1: 3 of 60 clouds are here; its robot is not connected"));
  brief.complete = true;
  away.connected = true;
  const auto less = explain(brief, away, nullptr, false, {}, name).missing;
  EXPECT_FALSE(says(less, "too short"));
  EXPECT_TRUE(says(less, "asked for"));
  away.clouds = 59;
  EXPECT_TRUE(says(explain(brief, away, nullptr, false, {}, name).missing, "59 of 60 clouds are here"));
  away.clouds = 60;
  EXPECT_FALSE(says(explain(brief, away, nullptr, false, {}, name).missing, "clouds are here"));
}

TEST(Explain, AJumpOfTheOdometryIsSaidWithWhatToDo) {
  ExplainedSession carried = session("ant/1");
  EXPECT_FALSE(says(explain(carried, session("bee/1"), nullptr, false, {}, name).missing, "left out of merging"));
  carried.why_cut = "from keyframe 7 on it is left out of merging: its odometry jumps 400 m";
  const auto missing = explain(carried, session("bee/1"), nullptr, false, {}, name).missing;
  EXPECT_TRUE(says(missing, "ant/1: from keyframe 7 on it is left out of merging: its odometry jumps 400 m"));
}

TEST(Explain, FamiliesThatDifferAreSaidWhereAMergeIsMissing) {
  ExplainedSession newer = session("bee/1");
  newer.family.version = 2;
  Alignment nothing;
  nothing.state = AlignmentState::rejected;
  EXPECT_TRUE(says(explain(session("ant/1"), newer, &nothing, false, {}, name).missing,
                   "ant/1 has scan_context version 1, bee/1 has scan_context version 2"));
  EXPECT_FALSE(says(explain(session("ant/1"), session("bee/1"), &nothing, false, {}, name).missing, "version"));
}

TEST(Explain, PairsNotTriedAreSaid) {
  const Explanation untried = explain(session("ant/1"), session("bee/1"), nullptr, false, {}, name);
  EXPECT_NE(untried.outcome.find("nothing has been tried yet"), std::string::npos);
  EXPECT_TRUE(says(untried.missing, "headframe merge"));
  EXPECT_NE(explain(session("ant/1"), session("bee/1"), nullptr, true, {}, name).outcome.find("through other sessions"),
            std::string::npos);
}

TEST(Explain, EveryStateAndDecisionHasItsWords) {
  Alignment k = good();
  std::vector<std::string> seen;
  for (const auto state : {AlignmentState::published, AlignmentState::candidate, AlignmentState::verified,
                           AlignmentState::retracted, AlignmentState::rejected}) {
    k.state = state;
    seen.push_back(explained(k).outcome);
  }
  k.ruling = Ruling::refused;
  seen.push_back(explained(k).outcome);
  EXPECT_NE(explained(k).decision.find("refused by the operator"), std::string::npos);
  k.ruling = Ruling::retracted;
  seen.push_back(explained(k).outcome);
  k.evidence = {};
  k.ruling = Ruling::none;
  seen.push_back(explained(k).outcome);
  EXPECT_TRUE(explained(k).findings.empty()) << "no placement: the figures mean nothing";
  std::sort(seen.begin(), seen.end());
  EXPECT_EQ(std::unique(seen.begin(), seen.end()), seen.end());
}

TEST(Explain, FiguresThatWereNotMeasuredAreLeftOut) {
  Alignment k = good();
  k.evidence.tilt_deg = std::numeric_limits<double>::quiet_NaN();
  const Explanation e = explained(k);
  for (const Finding& f : e.findings) EXPECT_NE(f.evidence, "tilt_deg");
}

}  // namespace
}  // namespace headframe
