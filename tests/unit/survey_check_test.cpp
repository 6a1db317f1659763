#include "server/atlas/survey_check.hpp"

#include <gtest/gtest.h>

#include <random>

namespace headframe {
namespace {

const Pose T_grid_session = pose_from_yaw(0.7, {431250.25, 6212400.5, -312.75});

std::string named(std::size_t at) { return std::string("P").append(std::to_string(at + 1)); }

/// Control points of a drift and a crosscut, measured to so many metres.
std::vector<ControlPoint> measured(std::size_t count, double noise_m, unsigned seed, const Pose& T = T_grid_session) {
  const std::vector<Eigen::Vector3d> places{{0, 0, 1},    {80, 3, 2},  {150, -4, 1.5},
                                            {40, 60, -3}, {90, 55, 0}, {10, -30, 2}};
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0, noise_m);
  std::vector<ControlPoint> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back({named(i), places[i], T * places[i] + Eigen::Vector3d(noise(rng), noise(rng), noise(rng))});
  return points;
}

Survey fitted(std::vector<ControlPoint> points) {
  const auto T = fit_survey(points);
  EXPECT_TRUE(T) << T.error().message;
  return {1, T.value_or(Pose::Identity()), std::move(points)};
}

std::string objection(const std::vector<ControlPoint>& points) {
  const auto fits = check_fit(fitted(points));
  return fits ? "" : fits.error().message;
}

TEST(SurveyCheck, GoodPointsFitAndNoneIsSuspected) {
  for (unsigned seed = 0; seed < 50; ++seed)
    for (const std::size_t count : {3, 4, 6}) {
      const auto points = measured(count, 0.01, seed);
      EXPECT_EQ(objection(points), "");
      EXPECT_FALSE(blunder_of(points)) << count << " points, seed " << seed;
    }
}

/// The case that was accepted silently: four points, one of them 2 m off in height, residuals of half a metre each.
TEST(SurveyCheck, OneOfFourThatIsTwoMetresOffIsNamedWhicheverItIsAndHowever) {
  for (const Eigen::Vector3d& off_m :
       {Eigen::Vector3d(0, 0, 2), Eigen::Vector3d(0, 0, -2), Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(-1, 1.5, 0.5)})
    for (std::size_t wrong = 0; wrong < 4; ++wrong)
      for (unsigned seed = 0; seed < 20; ++seed) {
        auto points = measured(4, 0.01, seed);
        points[wrong].p_grid_m += off_m;
        const auto found = blunder_of(points);
        ASSERT_TRUE(found) << "point " << wrong << " off by " << off_m.transpose();
        EXPECT_EQ(found->point, wrong);
        EXPECT_LT((found->off_m + off_m).norm(), 0.2);
        const std::string text = objection(points);
        EXPECT_NE(text.find(named(wrong) + " is likely wrong"), std::string::npos) << text;
      }
}

TEST(SurveyCheck, ASessionThatIsTiltedIsNoBlunderAndABlunderInItIsFound) {
  Pose tilted = T_grid_session;
  tilted.linear() = tilted.linear() * Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(objection(measured(6, 0.01, 1, tilted)), "");
  EXPECT_FALSE(blunder_of(measured(6, 0.01, 1, tilted)));
  auto points = measured(6, 0.01, 1, tilted);
  points[2].p_grid_m.z() += 3;
  const auto found = blunder_of(points);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->point, 2U);
}

TEST(SurveyCheck, WithThreePointsTheWrongOneCanNotBeTold) {
  auto points = measured(3, 0, 0);
  points.pop_back();
  points.push_back({"P3", {40, 60, -3}, T_grid_session * Eigen::Vector3d(40, 60.9, -3)});
  EXPECT_FALSE(blunder_of(points));
  EXPECT_NE(objection(points).find("add a fourth"), std::string::npos) << objection(points);
}

TEST(SurveyCheck, TwoWrongPointsAreRefusedWithoutNamingOne) {
  auto points = measured(4, 0, 0);
  points[0].p_grid_m.z() += 2;
  points[1].p_grid_m.z() -= 2;
  EXPECT_FALSE(blunder_of(points));
  EXPECT_NE(objection(points).find("can not be told: check all"), std::string::npos) << objection(points);
}

TEST(SurveyCheck, TheLimitGrowsWithTheDistances) {
  std::vector<ControlPoint> near{
      {"a", {0, 0, 0}, {0, 0, 0}}, {"b", {10, 0, 0}, {10, 0, 0}}, {"c", {0, 10, 0}, {0, 10, 0}}};
  // The three lie 4.71, 7.45 and 7.45 m from their middle.
  EXPECT_NEAR(allowed_residual_m(near), 0.10 + 0.002 * 6.667, 1e-4);
  const double just_m = allowed_residual_m(near);
  Survey survey{1, Pose::Identity(), near};
  survey.points[0].p_grid_m.x() = just_m - 1e-6;
  EXPECT_TRUE(check_fit(survey));
  survey.points[0].p_grid_m.x() = just_m + 1e-6;
  EXPECT_FALSE(check_fit(survey));
}

}  // namespace
}  // namespace headframe
