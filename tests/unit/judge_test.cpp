#include <gtest/gtest.h>

#include "server/verification/verification.hpp"
#include "tests/support/placed_clouds.hpp"

namespace headframe {
namespace {

using test::BoxMine;
using test::placed;

std::vector<KeyframePosition> stands(const std::vector<PlacedCloud>& clouds) {
  std::vector<KeyframePosition> out;
  for (std::size_t i = 0; i < clouds.size(); ++i) out.push_back({i, clouds[i].T_local_sensor.translation()});
  return out;
}

SubmapPtr submap_at(const std::vector<PlacedCloud>& clouds, std::size_t keyframe) {
  return std::make_shared<const Submap>(
      make_submap(clouds, clouds[keyframe].T_local_sensor.translation(), SubmapConfig{}));
}

Scene scene_of(const std::vector<PlacedCloud>& clouds_a, const std::vector<PlacedCloud>& clouds_b) {
  return {stands(clouds_a), stands(clouds_b), [&](std::span<const Meeting> meetings) {
            std::vector<SubmapPair> out;
            for (const Meeting& m : meetings)
              out.push_back({submap_at(clouds_a, m.keyframe_a), submap_at(clouds_b, m.keyframe_b)});
            return out;
          }};
}

/// The whole way from a guess to a judgement.
Judgement judged(const std::vector<PlacedCloud>& clouds_a, const std::vector<PlacedCloud>& clouds_b, const Pose& T_0,
                 const Eigen::Vector3d& p_b, const JudgeConfig& config = {}) {
  const Scene scene = scene_of(clouds_a, clouds_b);
  const auto meeting = first_meeting(scene.a, scene.b, T_0, p_b, config);
  if (!meeting) return {};
  const SubmapPair at = scene.places({&*meeting, 1}).front();
  const ScreeningResult first = screen_submaps(at.a, at.b, T_0, config);
  Judgement out = judge(scene, first, config);
  EXPECT_LE(out.evidence.probability, best_probability(first) + 1e-12);
  return out;
}

TEST(Judge, APlaceThatNothingSpeaksAgainstMayStillBeRight) {
  EXPECT_GT(best_probability({}), 0.99) << "or rivals of a copy would be spared, and it would be accepted";
  ScreeningResult contradicted;
  contradicted.place.a_by_b = {1000, 100, 0, 0};
  EXPECT_LT(best_probability(contradicted), 0.9);
  Evidence best = ideal_evidence();
  best.overlap_m = 30;
  EXPECT_LT(best_probability(contradicted, best), 0.1) << "so little path makes up for no contradiction";
}

TEST(Judge, TellsTheRightPlaceFromAWrongOne) {
  const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30), BoxMine::drift(10, -20, 10, 0, 6)});
  const auto a = drive(mine, {{5, 0}, {45, 0}}, 0, 1), b = drive(mine, {{30, 25}, {30, 0}, {15, 0}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const auto clouds_a = placed(a), clouds_b = placed(b);
  const Eigen::Vector3d crossing = b.T_mine_local.inverse() * Eigen::Vector3d(30, 0, 1);
  const Pose guess = truth * pose_from_yaw(0.1, {0.7, -0.6, 0});
  const Judgement right = judged(clouds_a, clouds_b, guess, crossing);
  EXPECT_GT(right.evidence.probability, 0.9);
  EXPECT_LT((right.T_a_b * crossing - truth * crossing).norm(), 0.05);
  EXPECT_NEAR(right.T_a_b.linear().determinant(), 1, 1e-9);
  EXPECT_GT(right.evidence.places, 1);
  EXPECT_GT(right.evidence.own_scatter_m, 0);
  EXPECT_LT(right.evidence.own_scatter_m, right.evidence.rmse_m) << "no session scatters less about the other's walls";
  JudgeConfig with_threads;
  with_threads.threads = 3;
  EXPECT_EQ(right.T_a_b.matrix(), judged(clouds_a, clouds_b, guess, crossing, with_threads).T_a_b.matrix());
  const Judgement wrong = judged(clouds_a, clouds_b, Eigen::Translation3d(-20, 0, 0) * truth, crossing);
  EXPECT_LT(wrong.evidence.probability, 0.5);
  EXPECT_EQ(judged({}, clouds_b, truth, crossing).status, RegistrationStatus::too_little_overlap);
  EXPECT_EQ(judged(clouds_a, clouds_b, Eigen::Translation3d(500, 0, 0) * truth, crossing).status,
            RegistrationStatus::too_little_overlap);
}

TEST(Judge, WhatContradictsAPlacementAsItIsNeedsNoRegistration) {
  constexpr double contradicts = 0.015;
  const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30), BoxMine::drift(10, -20, 10, 0, 6)});
  const auto a = drive(mine, {{5, 0}, {45, 0}}, 0, 1), b = drive(mine, {{30, 25}, {30, 0}, {15, 0}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const auto clouds_a = placed(a), clouds_b = placed(b);
  const Scene scene = scene_of(clouds_a, clouds_b);
  const auto at = [&](double x, double y, double yaw) {
    return violation_at(scene, Pose(Eigen::Translation3d(x, y, 0) * truth * pose_from_yaw(yaw, {0, 0, 0})), {});
  };
  EXPECT_LT(at(0, 0, 0), 0.002);
  EXPECT_LT(at(0.3, -0.2, 0.01), contradicts) << "as far as a chain of merges may be off";
  EXPECT_GT(at(-8, 0, 0), contradicts);
  EXPECT_GT(at(0, 6, 0), contradicts);
  EXPECT_EQ(at(500, 0, 0), 0) << "they do not meet";
  JudgeConfig with_threads;
  with_threads.threads = 3;
  const Pose wrong = Eigen::Translation3d(-8, 0, 0) * truth;
  EXPECT_EQ(violation_at(scene, wrong, {}), violation_at(scene, wrong, with_threads));
}

TEST(Judge, APlaceWhereRockLiesBetweenTheRobotsSaysNothing) {
  // Both drive the same drift; much later b passes 9 m from where a was: near enough to be asked, but there is no way
  // through.
  const BoxMine mine({BoxMine::drift(-40, -40, 0, -40), BoxMine::drift(-20, -40, -20, -28, 6),
                      BoxMine::drift(0, -40, 0, 0), BoxMine::drift(0, 0, 40, 0), BoxMine::drift(-36, -40, -36, 9),
                      BoxMine::drift(-36, 9, 30, 9)});
  const auto a = drive(mine, {{-38, -40}, {0, -40}, {0, 0}, {38, 0}}, 0, 1);
  const auto b = drive(mine, {{-8, -40}, {-36, -40}, {-36, 9}, {28, 9}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const Eigen::Vector3d branch = b.T_mine_local.inverse() * Eigen::Vector3d(-20, -40, 1);
  const Judgement right = judged(placed(a), placed(b), truth, branch);
  EXPECT_LT(right.evidence.places, JudgeConfig{}.places) << "some were left out";
  EXPECT_EQ(right.evidence.places_agreeing, right.evidence.places);
  EXPECT_GT(right.evidence.probability, 0.9);
}

TEST(Judge, AWrongPlacementThatItsFarthestPlaceRefutesIsNotJudgedAtTheOthers) {
  // Two mines that are alike but for a hall where the other goes on as a drift.
  std::vector<test::Box> alike{BoxMine::drift(0, 0, 60, 0), BoxMine::drift(8, -20, 8, 20)}, with_hall = alike;
  with_hall.push_back(BoxMine::drift(36, 0, 60, 0, 12));
  const auto a = drive(BoxMine(with_hall), {{3, 0}, {56, 0}}, 0, 1), b = drive(BoxMine(alike), {{3, 0}, {52, 0}}, 1, 2);
  const auto clouds_a = placed(a), clouds_b = placed(b);
  const Pose T_0 = a.T_mine_local.inverse() * b.T_mine_local;
  const Eigen::Vector3d begin = b.T_mine_local.inverse() * Eigen::Vector3d(8, 0, 1);
  const auto places = [&](double doubted_violation, double refuting_violation) {
    JudgeConfig config;
    config.doubted_violation = doubted_violation;
    config.refuting_violation = refuting_violation;
    const Judgement out = judged(clouds_a, clouds_b, T_0, begin, config);
    EXPECT_LT(out.evidence.probability, 0.1);
    EXPECT_GT(out.evidence.worst_place_violation, JudgeConfig{}.refuting_violation);
    return out.evidence.places;
  };
  const JudgeConfig config;
  EXPECT_EQ(places(0, config.refuting_violation), 2);
  EXPECT_EQ(places(0, 1), config.places) << "the farthest place does not contradict enough";
  EXPECT_EQ(places(config.doubted_violation, config.refuting_violation), config.places) << "the first one fits";
}

}  // namespace
}  // namespace headframe
