#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/mine/lidar.hpp"

namespace headframe::mine {
namespace {

RayCaster box_room(const Eigen::Vector3d& half_size) {
  Mesh mesh;
  add_box(mesh, {.centre = {0, 0, 0}, .half_size = half_size});
  return RayCaster(mesh);
}

Pose turned(double yaw_rad) { return pose_from_yaw(yaw_rad, {0.5, -0.3, 0.2}); }

TEST(Lidar, RangesInABoxAreThoseOfTheFormula) {
  const Eigen::Vector3d half(5, 3, 2);
  const LidarModel lidar = noiseless(*lidar_model("os0-64"));
  const Pose T_world_sensor = turned(0.7);
  const Scan scan = take_scan(box_room(half), lidar, T_world_sensor, 0, Rng(1));
  ASSERT_EQ(scan.points.size(), static_cast<std::size_t>(lidar.beams * lidar.columns));
  for (const auto& p : scan.points) {
    const Eigen::Vector3d q = T_world_sensor * p.cast<double>();
    EXPECT_NEAR((q.cwiseAbs() - half).maxCoeff(), 0, 2e-4) << q.transpose();
  }
}

TEST(Lidar, RangesInARoundDriftAreThoseOfTheFormula) {
  constexpr double radius_m = 2.5;
  constexpr int sides = 512;
  Mesh mesh;
  add_tube(mesh, {{-200, 0, 0}, {0, 0, 0}, {200, 0, 0}}, radius_m, sides);
  const LidarModel lidar = noiseless(*lidar_model("os1-32"));
  const Scan scan = take_scan(RayCaster(mesh), lidar, Pose::Identity(), 0, Rng(1));
  ASSERT_GT(scan.points.size(), 7000U);
  for (const auto& p : scan.points) {
    const double r = std::hypot(p.y(), p.z());
    EXPECT_LT(r, radius_m + 1e-3);
    EXPECT_GT(r, radius_m * std::cos(std::numbers::pi / sides) - 1e-3);
    EXPECT_LE(p.norm(), lidar.max_range_m + 1e-3);
  }
}

TEST(Lidar, NothingNearerThanTheShortestRange) {
  LidarModel lidar = noiseless(*lidar_model("os1-32"));
  const RayCaster room = box_room({1, 1, 1});
  lidar.min_range_m = 0.99;
  EXPECT_EQ(take_scan(room, lidar, Pose::Identity(), 0, Rng(1)).points.size(), 8192U);
  lidar.min_range_m = 1.09;  // walls straight ahead are gone, corners are left
  const std::size_t left = take_scan(room, lidar, Pose::Identity(), 0, Rng(1)).points.size();
  EXPECT_LT(left, 8192U);
  EXPECT_GT(left, 0U);
}

TEST(Lidar, NothingBeyondTheLongestRange) {
  LidarModel lidar = noiseless(*lidar_model("os1-32"));
  const RayCaster room = box_room({30, 30, 30});
  lidar.max_range_m = 29.9;
  EXPECT_TRUE(take_scan(room, lidar, Pose::Identity(), 0, Rng(1)).points.empty());
  lidar.max_range_m = 60;
  EXPECT_EQ(take_scan(room, lidar, Pose::Identity(), 0, Rng(1)).points.size(), 8192U);
}

TEST(Lidar, NoiseHasTheSizeOfTheModel) {
  LidarModel lidar = *lidar_model("vlp16-hires");
  lidar.dropout = 0;
  const Scan noisy = take_scan(box_room({8, 8, 8}), lidar, Pose::Identity(), 0, Rng(5));
  const Scan exact = take_scan(box_room({8, 8, 8}), noiseless(lidar), Pose::Identity(), 0, Rng(5));
  ASSERT_EQ(noisy.points.size(), exact.points.size());
  double sum = 0;
  for (std::size_t i = 0; i < noisy.points.size(); ++i)
    sum += std::pow(noisy.points[i].norm() - exact.points[i].norm(), 2);
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(noisy.points.size())), lidar.range_sigma_m, 0.002);
}

TEST(Lidar, DustAnswersAsOftenAsItsDensitySays) {
  const LidarModel lidar = noiseless(*lidar_model("os1-32"));
  const RayCaster room = box_room({50, 50, 50});
  const auto dust_returns = [&](double dust) {
    const Scan scan = take_scan(room, lidar, Pose::Identity(), dust, Rng(9));
    std::size_t near = 0;
    for (const auto& p : scan.points) near += p.norm() < 45 ? 1 : 0;
    return static_cast<double>(near) / 8192.0;
  };
  EXPECT_EQ(dust_returns(0), 0);
  EXPECT_NEAR(dust_returns(0.02), std::exp(-0.02 * lidar.min_range_m) - std::exp(-0.02 * 15), 0.02);
}

TEST(Lidar, DropoutsTakeTheirShare) {
  LidarModel lidar = noiseless(*lidar_model("os1-32"));
  lidar.dropout = 0.2;
  const Scan scan = take_scan(box_room({4, 4, 4}), lidar, Pose::Identity(), 0, Rng(3));
  EXPECT_NEAR(static_cast<double>(scan.points.size()) / 8192.0, 0.8, 0.03);
}

TEST(Lidar, UnknownModelsAreNone) {
  for (const char* name : {"os1-32", "vlp16-hires", "hdl-32e", "os0-64"}) EXPECT_TRUE(lidar_model(name)) << name;
  EXPECT_FALSE(lidar_model("os1"));
}

}  // namespace
}  // namespace headframe::mine
