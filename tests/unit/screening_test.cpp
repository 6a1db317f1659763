// The first registration of hypotheses: one place of an overlap may say nothing.
#include "server/merge/screening.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "server/merge/pair_search.hpp"
#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::BoxMine;
using test::Drive;

constexpr std::size_t blocked = 13;  // keyframes of session 2 in which a wall of dust stands around the robot

/// Session 1 drives along a drift with two crossings; session 2 comes back along most of it, its first 24 m in dust.
class ScreeningBehindDust : public testing::Test {
 protected:
  void SetUp() override {
    const BoxMine mine({BoxMine::drift(0, 0, 70, 0), BoxMine::drift(20, 0, 20, 30), BoxMine::drift(45, -20, 45, 0, 6)});
    Drive a = drive(mine, {{4, 0}, {66, 0}}, 0, 1, 2), b = drive(mine, {{62, 0}, {10, 0}}, 1, 2, 2);
    for (std::size_t i = 0; i < blocked; ++i)
      for (Eigen::Vector3f& p : b.clouds[i].sweeps.front().points) p = 1.2F * p.normalized();
    add(1, a);
    add(2, b);
    T_a_mine_ = a.T_mine_local.inverse();
    right_ = {.T_a_b = a.T_mine_local.inverse() * b.T_mine_local, .place_b = position(b.keyframes[0])};
  }
  void add(SessionId id, const Drive& drive) {
    sessions_.add(id, {"test", 1});
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
      sessions_.add_keyframe(id, drive.keyframes[i]);
      shelf_.clouds[{id, i + 1}] = drive.clouds[i];
    }
    sessions_.complete(id);
  }
  std::vector<Case> cases_of(const std::vector<Hypothesis>& hypotheses) {
    std::vector<Case> cases;
    cases.reserve(hypotheses.size());
    for (const Hypothesis& h : hypotheses) cases.push_back(requests_.make_case(1, 2, h, shelf_));
    return cases;
  }
  std::vector<ScreeningResult> screened(const std::vector<Hypothesis>& hypotheses, int threads = 1) {
    JudgeConfig judge = judge_config(config_);
    judge.threads = threads;
    SessionSubmaps submaps(config_, sessions_);
    return screen({1, 2}, cases_of(hypotheses), submaps, shelf_, judge);
  }

  /// The right one after others that lie nowhere.
  std::vector<Hypothesis> right_after(std::size_t others) const {
    Hypothesis nowhere = right_;
    nowhere.T_a_b = Eigen::Translation3d(500, 0, 0) * right_.T_a_b;
    std::vector<Hypothesis> all(others, nowhere);
    all.push_back(right_);
    return all;
  }
  /// Clouds are with the robots and come as they are asked for; returns how often, until nothing more is wanted.
  int rounds_of_asking(const std::vector<Hypothesis>& hypotheses, std::vector<Verdict>& verdicts) {
    for (const auto& [ref, cloud] : shelf_.clouds) shelf_.on_robots.insert(ref);
    std::vector<KeyframeRef> wanted = requests_.clouds_for_screening({1, 2}, requests_.make_case(1, 2, right_, shelf_));
    int rounds = 0;
    for (; !wanted.empty(); ++rounds) {
      for (const KeyframeRef& ref : wanted) shelf_.on_robots.erase(ref);
      AttemptReport report;
      Verdicts all = verifier_.judge_cases({1, 2}, cases_of(hypotheses), false, {shelf_, report});
      verdicts = all.judged;
      if (all.judged.empty()) all.judged.emplace_back();
      verifier_.ask_for_more({1, 2}, all, 0, {shelf_, report});
      wanted = report.wanted;
    }
    return rounds;
  }

  MergeConfig config_;
  SessionMap sessions_{config_};
  CloudRequests requests_{config_, sessions_};
  HypothesisFinder finder_{finder_config(config_)};
  SessionSubmaps submaps_{config_, sessions_};
  SelfSimilarity self_{config_, sessions_, finder_, submaps_, requests_};
  CandidateVerifier verifier_{config_, sessions_, submaps_, self_, requests_};
  test::Shelf shelf_;
  Pose T_a_mine_;
  Hypothesis right_;
};

TEST_F(ScreeningBehindDust, ARightPlacementIsFoundAtAnotherPlace) {
  for (const int threads : {1, 3}) {
    const ScreeningResult found = screened({right_}, threads).front();
    ASSERT_TRUE(found.hopeful);
    const Pose off = right_.T_a_b.inverse() * found.place.registration.T_target_source;
    EXPECT_LT((off * found.place.p_b - found.place.p_b).norm(), 0.1);
    EXPECT_GT((found.place.p_b - right_.place_b).norm(), 8) << "not in the dust";
  }
}

TEST_F(ScreeningBehindDust, CloudsOfAnotherPlaceAreAskedForIfTheyAreWithTheRobots) {
  std::vector<Verdict> verdicts;
  EXPECT_GE(rounds_of_asking({right_}, verdicts), 2);
  ASSERT_FALSE(verdicts.empty());
  EXPECT_GT((verdicts.front().p_b - right_.place_b).norm(), 8) << "not in the dust";
  EXPECT_LT((verdicts.front().judgement.T_a_b.inverse() * right_.T_a_b).translation().norm(), 0.2);
}

TEST_F(ScreeningBehindDust, OnlyTheThreeLikeliestAskForAnotherPlace) {
  for (const std::size_t before : {2, 3}) {
    std::vector<Verdict> verdicts;
    EXPECT_EQ(rounds_of_asking(right_after(before), verdicts) > 1, before < 3);
  }
}

TEST_F(ScreeningBehindDust, OfACandidateWhoseSessionsHaveEndedAllCloudsAreAskedFor) {
  for (const auto& [ref, cloud] : shelf_.clouds) shelf_.on_robots.insert(ref);
  for (const double off : {-0.01, 0.01}) {
    Verdicts doubted{{Verdict{}}}, alike = doubted;
    doubted.judged.front().judgement.evidence.probability = config_.candidate_probability + off;
    alike.judged.front().judgement.evidence.probability_if_unique = config_.accept_probability + off;
    for (const Verdicts& verdicts : {doubted, alike}) {
      const bool would_be_accepted = verdicts.judged.front().judgement.evidence.probability_if_unique > 0;
      AttemptReport report;
      EXPECT_EQ(verifier_.ask_for_more({1, 2}, verdicts, 0, {shelf_, report}), off > 0 && would_be_accepted);
      EXPECT_EQ(report.wanted.size(), off > 0 ? shelf_.clouds.size() : 0);
    }
  }
}

TEST_F(ScreeningBehindDust, OnlyTheFirstEightAreLookedAtTwice) {
  for (const std::size_t before : {7, 8}) EXPECT_EQ(screened(right_after(before)).back().hopeful, before < 8);
}

TEST_F(ScreeningBehindDust, WhatWasProposedAfterAHopefulOneIsNotLookedAtTwice) {
  // Half a turn lays one crossing on the other, as far as is seen from 20 m along the drift.
  Hypothesis turned = right_;
  const Pose T_mine_turned = pose_from_yaw(std::numbers::pi, {65, 0, 0});
  turned.T_a_b = T_a_mine_ * T_mine_turned * T_a_mine_.inverse() * right_.T_a_b;
  turned.place_b = right_.T_a_b.inverse() * Eigen::Vector3d(16, 0, 0);
  ASSERT_TRUE(screened({turned}).front().hopeful);
  EXPECT_FALSE(screened({turned, right_})[1].hopeful);
  EXPECT_TRUE(screened({right_, turned})[0].hopeful);
}

TEST_F(ScreeningBehindDust, APlacementThatIsKnownIsNotCountedTwice) {
  Hypothesis in_the_clear = right_;
  in_the_clear.place_b = right_.T_a_b.inverse() * Eigen::Vector3d(16, 0, 0);
  EXPECT_TRUE(screened({in_the_clear}).front().hopeful);
  for (const bool dust_first : {true, false}) {
    const auto both = dust_first ? screened({right_, in_the_clear}) : screened({in_the_clear, right_});
    EXPECT_EQ(both[0].hopeful, !dust_first);
    EXPECT_EQ(both[1].hopeful, dust_first);
  }
}

TEST_F(ScreeningBehindDust, SomeAreRegisteredFullyForTheirWallScoreAlone) {
  Hypothesis likely = right_, contradicted = right_;
  likely.place_b = contradicted.place_b = right_.T_a_b.inverse() * Eigen::Vector3d(16, 0, 0);
  likely.score = 100;
  contradicted.contradiction = 10;
  std::vector<Hypothesis> all(JudgeConfig{}.screened_fully + 1, likely);
  all.push_back(contradicted);
  for (const double score : {99, 101}) {
    all.back().score = score;
    EXPECT_EQ(screened(all).back().hopeful, score > likely.score);
  }
}

TEST_F(ScreeningBehindDust, ThePlaceThatWasScreenedIsFoundAgain) {
  const ScreeningResult found = screened({right_}).front();
  SessionSubmaps submaps(config_, sessions_);
  const Case c = requests_.make_case(1, 2, right_, shelf_);
  const SubmapPair again = place_screened({1, 2}, c, found.place, submaps, shelf_, judge_config(config_));
  ASSERT_TRUE(again.a && again.b);
  EXPECT_EQ(again.a->p, found.a->p);
  EXPECT_EQ(again.b->p, found.b->p);
  EXPECT_FALSE(place_screened({1, 2}, {}, found.place, submaps, shelf_, judge_config(config_)).a)
      << "no clouds are left there";
}

}  // namespace
}  // namespace headframe
