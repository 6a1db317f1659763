#include "server/registration/vgicp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "server/registration/surfels.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
constexpr double degree = std::numbers::pi / 180;
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

const BoxMine& crossing() {
  static const BoxMine mine(
      {BoxMine::drift(-30, 0, 30, 0), BoxMine::drift(0, -30, 0, 30), BoxMine::drift(8, 0, 8, 5, 3, 2)});
  return mine;
}

Surfels seen_from(const BoxMine& mine, const Pose& T_mine_sensor, unsigned seed) {
  std::mt19937 rng(seed);
  return make_surfels(voxel_grid(mine.scan(T_mine_sensor, rng), 0.25F));
}

Registration vgicp(const Surfels& target, const Surfels& source, const Pose& T_0, int threads = 1) {
  VgicpConfig config;
  config.threads = threads;
  return align(make_voxel_maps(target.points, target.normals, config), source.points, source.normals, T_0, config);
}

const Pose T_a = pose_from_yaw(0, {0, 0, 1.2});
const Pose T_b = pose_from_yaw(0.6, {1.5, 0.5, 1.4});

using Cell = std::array<int, 3>;
Cell cell_of(const Eigen::Vector3f& p, float leaf_m) {
  return {static_cast<int>(std::floor(p.x() / leaf_m)), static_cast<int>(std::floor(p.y() / leaf_m)),
          static_cast<int>(std::floor(p.z() / leaf_m))};
}

TEST(VoxelMap, AgreesWithBruteForce) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> u(-10, 10);
  Points points(4000), normals(4000, Eigen::Vector3f::UnitZ());
  for (auto& p : points) p = {u(rng), u(rng), 0.3F * u(rng)};
  const VoxelMap map(points, normals, 0.5F);
  std::map<Cell, std::pair<Eigen::Vector3d, int>> oracle;
  for (const auto& p : points) {
    auto& [sum, count] = oracle.try_emplace(cell_of(p, 0.5F), Eigen::Vector3d::Zero(), 0).first->second;
    sum += p.cast<double>();
    ++count;
  }
  EXPECT_EQ(map.voxels().size(), oracle.size());
  int found = 0, missed = 0;
  Points asked;
  for (int i = 0; i < 4000; ++i) asked.emplace_back(u(rng), u(rng), 0.5F * u(rng));
  std::vector<const Voxel*> answers(asked.size());
  map.nearest(asked, answers);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const Eigen::Vector3f& p = asked[i];
    const Cell low = cell_of(p - Eigen::Vector3f::Constant(0.25F), 0.5F);
    double least = std::numeric_limits<double>::max();
    for (int corner = 0; corner < 8; ++corner) {
      const auto voxel = oracle.find({low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2)});
      if (voxel == oracle.end()) continue;
      const auto& [sum, count] = voxel->second;
      least = std::min(least, (sum / count - p.cast<double>()).norm());
    }
    const Voxel* nearest = map.nearest(p);
    ASSERT_EQ(answers[i], nearest);
    ASSERT_EQ(nearest != nullptr, least < std::numeric_limits<double>::max());
    (nearest ? found : missed) += 1;
    if (nearest) {
      EXPECT_NEAR((nearest->mean - p).norm(), least, 1e-4);
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(missed, 100);
}

TEST(VoxelMap, ReachesFiveHundredLeavesFromItsFirstPoint) {
  const Points points{{0.5F, 0.5F, 0.5F}, {-499.5F, 0.5F, 0.5F}, {0.5F, 500.5F, 0.5F}, {0.5F, 0.5F, 501.5F}};
  const VoxelMap map(points, Points(4, Eigen::Vector3f::UnitX()), 1);
  EXPECT_EQ(map.voxels().size(), 3U);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(map.nearest(points[i] + Eigen::Vector3f::Constant(0.2F)) != nullptr, i < 3) << i;
}

TEST(VoxelMap, LeavesOutWhatIsNotAPlace) {
  const float inf = std::numeric_limits<float>::infinity();
  const Points points{{1, 1, 1}, {nan, 0, 0}, {0, inf, 0}, {0, 0, -2e6F}, {1, 1, 1}};
  const VoxelMap map(points, Points(5, Eigen::Vector3f::UnitX()), 1);
  ASSERT_EQ(map.voxels().size(), 1U);
  EXPECT_EQ(map.voxels()[0].count, 2);
  EXPECT_EQ(map.nearest({nan, 0, 0}), nullptr);
  EXPECT_EQ(map.nearest({0, 0, inf}), nullptr);
  EXPECT_EQ(map.nearest({4, 4, 4}), nullptr);
  EXPECT_EQ(VoxelMap().nearest({0, 0, 0}), nullptr);
}

TEST(Vgicp, FindsTheTruthFromWithinItsBasin) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_b, 2);
  const Pose truth = T_a.inverse() * T_b;
  for (const double yaw_deg : {-15.0, 0.0, 15.0}) {
    const Pose start = pose_from_yaw(0.6 + yaw_deg * degree, truth.translation() + Eigen::Vector3d(0.8, -0.6, 0.1));
    const Registration r = vgicp(a, b, start);
    EXPECT_EQ(r.status, RegistrationStatus::converged) << yaw_deg;
    EXPECT_LT((r.T_target_source.translation() - truth.translation()).norm(), 0.03) << yaw_deg;
    EXPECT_LT(rotation_angle_rad(truth.inverse() * r.T_target_source), 0.2 * degree) << yaw_deg;
    EXPECT_NEAR(r.T_target_source.linear().determinant(), 1.0, 1e-9);
  }
}

TEST(Vgicp, ThreadsDoNotChangeTheResult) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_b, 2);
  const Registration one = vgicp(a, b, pose_from_yaw(0.5, {1, 1, 0}));
  for (int threads : {2, 3, 4}) {
    const Registration many = vgicp(a, b, pose_from_yaw(0.5, {1, 1, 0}), threads);
    EXPECT_EQ(one.T_target_source.matrix(), many.T_target_source.matrix());
    EXPECT_EQ(one.information, many.information);
  }
}

TEST(Vgicp, SaysThatASmoothDriftDoesNotHoldItsAxis) {
  const BoxMine drift({BoxMine::drift(-200, 0, 200, 0)});
  const Surfels a = seen_from(drift, T_a, 1), b = seen_from(drift, pose_from_yaw(0, {3, 0.2, 1.2}), 2);
  const Registration r = vgicp(a, b, Pose::Identity());
  EXPECT_EQ(r.status, RegistrationStatus::degenerate);
  EXPECT_GT(std::abs(r.weakest_direction.x()), 0.99);
}

TEST(Vgicp, BadCloudsGiveAStatus) {
  const Surfels good = seen_from(crossing(), T_a, 1);
  Surfels far = good, huge = good;
  for (auto& p : far.points) p.x() += 1000;
  for (auto& p : huge.points) p *= 1000;
  for (const Surfels& bad : {Surfels{}, far, huge}) {
    EXPECT_EQ(vgicp(good, bad, Pose::Identity()).status, RegistrationStatus::too_little_overlap);
    EXPECT_EQ(vgicp(bad, good, Pose::Identity()).status, RegistrationStatus::too_little_overlap);
  }
  EXPECT_EQ(align(VoxelMaps{}, good.points, good.normals, Pose::Identity()).status,
            RegistrationStatus::too_little_overlap);
}

TEST(Vgicp, ScatterIsWhatARegistrationWouldReport) {
  const Surfels a = seen_from(crossing(), T_a, 1), b = seen_from(crossing(), T_a, 2);
  const VoxelMaps map = make_voxel_maps(a.points, a.normals);
  VgicpConfig as_it_is;
  as_it_is.iterations = 0;
  const Registration r = align(map, b.points, b.normals, Pose::Identity(), as_it_is);
  EXPECT_GT(r.rmse_m, 0);
  EXPECT_EQ(scatter_m(map, b.points, b.normals), r.rmse_m);
  EXPECT_EQ(scatter_m(map, {}, {}), 0);
}

TEST(Vgicp, ScatterOfAPlaneIsItsNoise) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> u(-10, 10);
  const auto rough = [&](float noise_m) {
    std::normal_distribution<float> normal(0, noise_m);
    Points points(40000);
    for (auto& p : points) p = {u(rng), u(rng), normal(rng) + 0.25F};
    const Points normals(points.size(), Eigen::Vector3f::UnitZ());
    return scatter_m(make_voxel_maps(points, normals), points, normals);
  };
  const double smooth_m = rough(0.01F), rough_m = rough(0.04F);
  EXPECT_NEAR(smooth_m, 0.01, 0.002);
  EXPECT_NEAR(rough_m, 0.04, 0.008);
}

}  // namespace
}  // namespace headframe
