#include "server/registration/sphere_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace headframe {
namespace {

using Rng = std::mt19937;

Points random_points(std::size_t count, float size_m, Rng& rng) {
  std::uniform_real_distribution<float> u(-size_m, size_m);
  Points points(count);
  for (auto& p : points) p = {u(rng), u(rng), 0.2F * u(rng)};
  return points;
}

Pose random_pose(Rng& rng) {
  std::uniform_real_distribution<double> u(-1, 1);
  return pose_from_yaw(3 * u(rng), {40 * u(rng), 40 * u(rng), 5 * u(rng)});
}

bool by_place(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

TEST(SphereIndex, AgreesWithBruteForce) {
  Rng rng(1);
  SphereIndex index;
  Points all;
  for (int i = 0; i < 20; ++i) {
    const Points points = random_points(500, 20, rng);
    const Pose T = random_pose(rng);
    const Eigen::Matrix3f R = T.linear().cast<float>();
    const Eigen::Vector3f t = T.translation().cast<float>();
    for (const auto& p : points) all.emplace_back(R * p + t);
    index.add(T, std::make_shared<ChunkedCloud>(cut_into_chunks(points, points)));
  }
  for (const double radius_m : {0.5, 5.0, 25.0, 1000.0})
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3f centre = random_points(1, 40, rng)[0];
      const auto r = static_cast<float>(radius_m);
      Points oracle;
      for (const auto& p : all)
        if ((p - centre).squaredNorm() < r * r) oracle.push_back(p);
      auto found = index.sphere(centre.cast<double>(), radius_m);
      EXPECT_EQ(found.normals.size(), found.points.size());
      std::sort(oracle.begin(), oracle.end(), by_place);
      std::sort(found.points.begin(), found.points.end(), by_place);
      EXPECT_EQ(found.points, oracle) << radius_m;
    }
}

TEST(SphereIndex, SaysWhichCloudsHavePointsThereAndTurnsNormals) {
  const Points one{{1, 0, 0}};
  const auto cloud = std::make_shared<ChunkedCloud>(cut_into_chunks(one, {Eigen::Vector3f::UnitX()}));
  SphereIndex index;
  index.add(pose_from_yaw(0, {0, 0, 0}), cloud);
  index.add(pose_from_yaw(0, {100, 0, 0}), cloud);
  index.add(pose_from_yaw(std::acos(0.0), {0, 0, 0}), cloud);
  const auto found = index.sphere({0, 0, 0}, 2);
  EXPECT_EQ(found.clouds, (std::vector<std::uint32_t>{0, 2}));
  ASSERT_EQ(found.normals.size(), 2U);
  EXPECT_LT((found.normals[1] - Eigen::Vector3f::UnitY()).norm(), 1e-6F);
}

TEST(SphereIndex, TheBorderIsOutside) {
  SphereIndex index;
  index.add(Pose::Identity(), std::make_shared<ChunkedCloud>(cut_into_chunks({{2, 0, 0}})));
  EXPECT_TRUE(index.sphere({0, 0, 0}, 2).points.empty());
  EXPECT_EQ(index.sphere({0, 0, 0}, 2.001).points.size(), 1U);
}

TEST(SphereIndex, NothingIsFoundWhereNothingCanBe) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const ChunkedCloud cut = cut_into_chunks({{nan, 0, 0}, {1, 1, 1}, {0, std::numeric_limits<float>::infinity(), 0}});
  EXPECT_EQ(cut.points, Points({{1, 1, 1}}));
  SphereIndex index;
  EXPECT_TRUE(index.sphere({0, 0, 0}, 25).points.empty());
  Pose broken = Pose::Identity();
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  index.add(broken, std::make_shared<ChunkedCloud>(cut));
  EXPECT_TRUE(index.sphere({0, 0, 0}, 25).points.empty());
  EXPECT_TRUE(index.sphere(Eigen::Vector3d::Constant(static_cast<double>(nan)), 25).points.empty());
  EXPECT_TRUE(index.sphere({0, 0, 0}, -1).points.empty());
}

}  // namespace
}  // namespace headframe
