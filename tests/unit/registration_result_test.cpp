// What all engines promise of their result, whatever they are given.

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <numbers>
#include <random>

#include "server/registration/pcl_gicp.hpp"
#include "server/registration/vgicp.hpp"
#include "tests/bench/registration/gicp.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
using Engine = std::function<Registration(const Surfels& target, const Surfels& source, const Pose& T_0, int threads)>;

Registration by_gicp(const Surfels& target, const Surfels& source, const Pose& T_0, int threads) {
  GicpConfig config;
  config.threads = threads;
  return align(target, source, T_0, config);
}

Registration by_vgicp(const Surfels& target, const Surfels& source, const Pose& T_0, int threads) {
  VgicpConfig config;
  config.threads = threads;
  return align(make_voxel_maps(target.points, target.normals, config), source.points, source.normals, T_0, config);
}

/// As the server does it when it is told to use PCL's (verification/submap_check.cpp).
Registration by_pcl(const Surfels& target, const Surfels& source, const Pose& T_0, int threads) {
  VgicpConfig config;
  config.threads = threads;
  config.levels = {config.levels.back()};
  return align(make_voxel_maps(target.points, target.normals, config), source.points, source.normals,
               pcl_gicp(target.points, source.points, T_0), config);
}

class Engines : public testing::TestWithParam<Engine> {};
std::string engine_name(const testing::TestParamInfo<Engine>& engine) {
  return std::array{"Gicp", "Vgicp", "Pcl"}.at(engine.index);
}
INSTANTIATE_TEST_SUITE_P(All, Engines, testing::Values(by_gicp, by_vgicp, by_pcl), engine_name);

Points scan(const BoxMine& mine, const Pose& T_mine_sensor, unsigned seed) {
  std::mt19937 rng(seed);
  return voxel_grid(mine.scan(T_mine_sensor, rng), 0.25F);
}

const BoxMine& crossing() {
  static const BoxMine mine(
      {BoxMine::drift(-30, 0, 30, 0), BoxMine::drift(0, -30, 0, 30), BoxMine::drift(8, 0, 8, 5, 3, 2)});
  return mine;
}

const Pose T_a = pose_from_yaw(0, {0, 0, 1.2});
const Pose T_b = pose_from_yaw(0.3, {1.0, 0.5, 1.4});
const Pose truth = T_a.inverse() * T_b;

const Surfels& cloud_a() {
  static const Surfels surfels = make_surfels(scan(crossing(), T_a, 1));
  return surfels;
}
const Surfels& cloud_b() {
  static const Surfels surfels = make_surfels(scan(crossing(), T_b, 2));
  return surfels;
}

Points moved(const Pose& T, const Points& points) {
  Points out;
  out.reserve(points.size());
  for (const auto& p : points) out.emplace_back((T * p.cast<double>()).cast<float>());
  return out;
}

void expect_near(const Pose& a, const Pose& b, double metres, double degrees) {
  EXPECT_LT((a.inverse() * b).translation().norm(), metres);
  EXPECT_LT(rotation_angle_rad(a.inverse() * b) * 180 / std::numbers::pi, degrees);
}

TEST_P(Engines, SwappingGivesTheInverse) {
  const Registration there = GetParam()(cloud_a(), cloud_b(), truth, 1),
                     back = GetParam()(cloud_b(), cloud_a(), truth.inverse(), 1);
  expect_near(there.T_target_source, back.T_target_source.inverse(), 0.03, 0.2);
}

TEST_P(Engines, MovingBothCloudsChangesNothingBetweenThem) {
  const Pose move_a = pose_from_yaw(2.0, {100, -50, 3}), move_b = pose_from_yaw(-1.0, {-20, 70, 1});
  const Surfels a = make_surfels(moved(move_a, cloud_a().points)), b = make_surfels(moved(move_b, cloud_b().points));
  const Registration plain = GetParam()(cloud_a(), cloud_b(), truth, 1),
                     after = GetParam()(a, b, move_a * truth * move_b.inverse(), 1);
  expect_near(plain.T_target_source, move_a.inverse() * after.T_target_source * move_b, 0.02, 0.1);
}

TEST_P(Engines, OneToFourThreadsGiveTheSameBits) {
  const Registration one = GetParam()(cloud_a(), cloud_b(), Pose::Identity(), 1);
  EXPECT_NEAR(one.T_target_source.linear().determinant(), 1, 1e-12);
  for (int threads : {2, 3, 4}) {
    const Registration many = GetParam()(cloud_a(), cloud_b(), Pose::Identity(), threads);
    EXPECT_EQ(one.T_target_source.matrix(), many.T_target_source.matrix());
    EXPECT_EQ(one.information, many.information);
    EXPECT_EQ(one.residuals.p90_m, many.residuals.p90_m);
    EXPECT_EQ(make_surfels(cloud_a().points, 20, threads).normals, make_surfels(cloud_a().points, 20, 1).normals);
  }
}

TEST_P(Engines, ACrossingHoldsEverything) {
  const Registration r = GetParam()(cloud_a(), cloud_b(), truth, 1);
  EXPECT_EQ(r.status, RegistrationStatus::converged);
  EXPECT_TRUE(r.free_directions.empty());
  EXPECT_GT(r.inlier_fraction, 0.6);
  EXPECT_GT(r.iterations, 0);
  EXPECT_LE(r.residuals.median_m, r.residuals.p90_m);
  EXPECT_LE(r.residuals.p90_m, r.residuals.p99_m);
  EXPECT_LT(r.residuals.median_m, 0.02);  // the scans' noise is 1 cm
}

TEST_P(Engines, AStraightDriftIsFreeAlongItsAxisAndSaysSo) {
  const BoxMine drift({BoxMine::drift(-200, 0, 200, 0)});
  const Surfels a = make_surfels(scan(drift, T_a, 1)),
                b = make_surfels(scan(drift, pose_from_yaw(0, {3, 0.2, 1.2}), 2));
  const Registration r = GetParam()(a, b, Pose::Identity(), 1);
  EXPECT_EQ(r.status, RegistrationStatus::degenerate);
  ASSERT_EQ(r.free_directions.size(), 1U);
  EXPECT_EQ(r.free_directions[0].kind, FreeDirection::Kind::translation);
  EXPECT_GT(std::abs(r.free_directions[0].axis.x()), 0.99);
  EXPECT_EQ(to_string(r.free_directions[0]).substr(0, 18), "translation along ");
}

TEST_P(Engines, OnePlaneIsFreeInThreeWays) {
  Points plane;
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> u(-10, 10);
  std::normal_distribution<float> noise(0, 0.01F);
  for (int i = 0; i < 3000; ++i) plane.emplace_back(u(rng), u(rng), noise(rng));
  const Surfels surfels = make_surfels(plane);
  const Registration r = GetParam()(surfels, surfels, pose_from_yaw(0, {0, 0, 0.1}), 1);
  EXPECT_EQ(r.status, RegistrationStatus::degenerate);
  ASSERT_EQ(r.free_directions.size(), 3U);
  for (const FreeDirection& d : r.free_directions) {
    const bool translation = d.kind == FreeDirection::Kind::translation;
    EXPECT_NEAR(std::abs(d.axis.z()), translation ? 0 : 1, 0.02) << to_string(d);
  }
}

TEST_P(Engines, BadCloudsGiveAStatus) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  Points line, far = moved(pose_from_yaw(0, {1000, 0, 0}), cloud_b().points), huge = cloud_b().points, tiny = huge;
  for (int i = 0; i < 100; ++i) line.emplace_back(0.1F * static_cast<float>(i), 0, 0);
  for (auto& p : huge) p *= 1000;
  for (auto& p : tiny) p *= 0.001F;
  const Points ten(cloud_b().points.begin(), cloud_b().points.begin() + 10);
  const std::vector<Points> bad{{},
                                line,
                                far,
                                huge,
                                Points(5000, Eigen::Vector3f(1, 1, 1)),
                                Points(50, {nan, nan, nan}),
                                Points(50, {inf, 0, 0})};
  for (std::size_t i = 0; i < bad.size(); ++i) {
    const Surfels surfels = make_surfels(bad[i]);
    EXPECT_EQ(GetParam()(cloud_a(), surfels, truth, 1).status, RegistrationStatus::too_little_overlap) << i;
    EXPECT_EQ(GetParam()(surfels, cloud_a(), truth, 1).status, RegistrationStatus::too_little_overlap) << i;
  }
  // Ten points of a wall, or a dot of 4 cm, may stick to another wall, but are not taken for a place.
  for (const Points& little : {ten, tiny}) {
    const Surfels surfels = make_surfels(little);
    EXPECT_NE(GetParam()(cloud_a(), surfels, truth, 1).status, RegistrationStatus::converged);
    EXPECT_NE(GetParam()(surfels, cloud_a(), truth, 1).status, RegistrationStatus::converged);
  }
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(GetParam()(cloud_a(), cloud_b(), broken, 1).status, RegistrationStatus::too_little_overlap);
}

TEST_P(Engines, APointThatIsNotAPlaceDoesNotSpoilTheRest) {
  Points points = cloud_b().points;
  points[0].x() = std::numeric_limits<float>::quiet_NaN();
  points[7].z() = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 100; ++i) points.push_back(points[20]);
  const Registration r = GetParam()(cloud_a(), make_surfels(points), truth, 1);
  EXPECT_EQ(r.status, RegistrationStatus::converged);
  expect_near(r.T_target_source, truth, 0.03, 0.2);
}

}  // namespace
}  // namespace headframe
