#include "server/atlas/survey.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace headframe {
namespace {

/// A session in a mine grid far from its origin: 431 km east, 6.2 thousand km north.
const Pose T_grid_session = pose_from_yaw(0.7, {431250.25, 6212400.5, -312.75});

std::vector<ControlPoint> points_at(const std::vector<Eigen::Vector3d>& places_m, const Pose& T = T_grid_session) {
  std::vector<ControlPoint> points;
  points.reserve(places_m.size());
  for (const Eigen::Vector3d& p : places_m) points.push_back({std::to_string(points.size() + 1), p, T * p});
  return points;
}

const std::vector<Eigen::Vector3d> spread_m{{0, 0, 1}, {80, 3, 2}, {150, -4, 1.5}, {40, 60, -3}};

std::string refusal(const std::vector<ControlPoint>& points) {
  const auto fitted = fit_survey(points);
  return fitted ? "" : fitted.error().message;
}

TEST(Survey, FindsAKnownTransformToANanometreAMillionMetresAway) {
  const auto fitted = fit_survey(points_at(spread_m));
  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_LT((fitted->translation() - T_grid_session.translation()).norm(), 1e-6);
  EXPECT_LT(rotation_angle_rad(fitted->inverse() * T_grid_session), 1e-9);
  Survey survey{1, *fitted, points_at(spread_m)};
  for (const double residual : residuals_m(survey)) EXPECT_LT(residual, 1e-6);
}

TEST(Survey, ThreePointsAreEnoughAndTwoAreNot) {
  EXPECT_EQ(refusal(points_at({spread_m[0], spread_m[1], spread_m[3]})), "");
  EXPECT_NE(refusal(points_at({spread_m[0], spread_m[3]})).find("2 points; give 3"), std::string::npos);
  EXPECT_NE(refusal({}).find("0 points"), std::string::npos);
}

/// Least squares: any small change of the transform that was found makes the sum of squares larger.
TEST(Survey, NoisyPointsGetTheBestFitAndTheirResiduals) {
  std::mt19937 rng(7);
  std::normal_distribution<double> noise_m(0, 0.03);
  auto points = points_at(spread_m);
  for (ControlPoint& point : points) point.p_grid_m += Eigen::Vector3d(noise_m(rng), noise_m(rng), noise_m(rng));
  const auto fitted = fit_survey(points);
  ASSERT_TRUE(fitted);
  const auto squares = [&](const Pose& T) {
    double sum = 0;
    for (const double r : residuals_m({1, T, points})) sum += r * r;
    return sum;
  };
  const double least = squares(*fitted);
  EXPECT_NEAR(rms_m(residuals_m({1, *fitted, points})), std::sqrt(least / 4), 1e-12);
  EXPECT_LT(rms_m(residuals_m({1, *fitted, points})), 0.09);
  const Pose about =
      Pose(Eigen::Translation3d(points[0].p_grid_m));  // a turn about the origin would move it by kilometres
  for (int axis = 0; axis < 6; ++axis)
    for (const double step : {-1e-4, 1e-4}) {
      Vector6d d = Vector6d::Zero();
      d[axis] = step;
      EXPECT_GT(squares(about * se3_exp(d) * about.inverse() * *fitted), least) << axis;
    }
}

TEST(Survey, PointsInALineAreRefusedAndThoseAMetreBesideItAreTaken) {
  const auto beside = [](double metres) { return points_at({{0, 0, 0}, {50, 0, 0}, {100, 0, 0}, {50, metres, 0}}); };
  EXPECT_NE(refusal(beside(0)).find("in a line"), std::string::npos);
  // One of four beside the line by d is sqrt(3)/4 d rms from the best line: 1 m at 2.309 m.
  EXPECT_NE(refusal(beside(2.30)).find("in a line, to within"), std::string::npos);
  EXPECT_EQ(refusal(beside(2.32)), "");
}

TEST(Survey, AnotherScaleIsRefused) {
  const auto scaled = [](double scale) {
    auto points = points_at(spread_m);
    for (ControlPoint& point : points) point.p_session_m /= scale;
    return points;
  };
  EXPECT_EQ(refusal(scaled(1.019)), "");
  EXPECT_NE(refusal(scaled(1.021)).find("1.0210 times"), std::string::npos) << refusal(scaled(1.021));
  EXPECT_EQ(refusal(scaled(0.981)), "");
  EXPECT_NE(refusal(scaled(0.979)).find("0.9790 times"), std::string::npos);
  EXPECT_NE(refusal(scaled(3.2808)).find("metres"), std::string::npos) << "feet";
}

TEST(Survey, SwappedAxesAndTiltsAreRefused) {
  auto points = points_at(spread_m);
  for (ControlPoint& point : points) std::swap(point.p_grid_m.x(), point.p_grid_m.y());
  EXPECT_NE(refusal(points).find("easting and northing swapped"), std::string::npos) << refusal(points);
  const auto tilted = [](double rad) {
    Pose T = T_grid_session;
    T.rotate(Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitX()));
    return points_at(spread_m, T);
  };
  EXPECT_EQ(refusal(tilted(0.174)), "");
  EXPECT_NE(refusal(tilted(0.176)).find("tilt the level session by 10 deg"), std::string::npos);
}

TEST(Survey, NumbersHaveALimit) {
  auto points = points_at(spread_m);
  points[1].p_grid_m.z() = std::nan("");
  EXPECT_NE(refusal(points).find("\"2\""), std::string::npos);
  const Pose far = Pose(Eigen::Translation3d(0.99e8, 0, 0)), too_far = Pose(Eigen::Translation3d(1.01e8, 0, 0));
  EXPECT_EQ(refusal(points_at(spread_m, far)), "");
  EXPECT_NE(refusal(points_at(spread_m, too_far)).find("beyond"), std::string::npos);
}

TEST(Survey, AGivenTransformIsRigidAndUpright) {
  EXPECT_TRUE(checked_survey(T_grid_session.matrix())->isApprox(T_grid_session));
  Eigen::Matrix4d stretched = T_grid_session.matrix(), mirrored = stretched, skewed = stretched, sick = stretched;
  stretched.topLeftCorner<3, 3>() *= 1.001;
  EXPECT_FALSE(checked_survey(stretched)) << "R^T R is off by 0.002";
  stretched.topLeftCorner<3, 3>() *= 1.0004 / 1.001;
  EXPECT_TRUE(checked_survey(stretched));
  EXPECT_NEAR(checked_survey(stretched)->linear().determinant(), 1, 1e-12) << "made orthonormal";
  mirrored.row(0).swap(mirrored.row(1));
  EXPECT_NE(checked_survey(mirrored).error().message.find("mirror"), std::string::npos);
  skewed(3, 0) = 0.5;
  EXPECT_FALSE(checked_survey(skewed));
  sick(0, 3) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(checked_survey(sick));
}

TEST(Survey, TheOneSetLastPlacesTheComponent) {
  const Pose T_1_2 = pose_from_yaw(0.5, {10, 20, 1});
  const Component component{1, {{1, Pose::Identity()}, {2, T_1_2}}};
  const Survey of_1{1, T_grid_session, {}}, of_2{2, pose_from_yaw(0.1, {1, 2, 3}), {}}, of_9{9, Pose::Identity(), {}};
  EXPECT_FALSE(grid_of(component, {}));
  EXPECT_FALSE(grid_of(component, std::vector{of_9}));
  EXPECT_TRUE(grid_of(component, std::vector{of_2, of_1, of_9})->isApprox(T_grid_session));
  EXPECT_TRUE(grid_of(component, std::vector{of_1, of_2})->isApprox(of_2.T_grid_session * T_1_2.inverse()));
}

}  // namespace
}  // namespace headframe
