// Clouds that no lidar sees: they cost what honest ones cost. Each of these once took minutes and more; the time limit
// of the test is what fails then.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/registration/kd_tree.hpp"
#include "server/verification/prepared_cloud.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_decoded = 4'000'000;

KeyframeCloud one_sweep(Points points) { return {{Sweep{Eigen::Vector3f::Zero(), std::move(points)}}}; }

Points wall(float at_m, std::size_t side) {
  Points points;
  for (std::size_t i = 0; i < side * side; ++i)
    points.emplace_back(at_m, 0.1F * static_cast<float>(i % side),
                        0.1F * static_cast<float>(i / side));  // NOLINT(bugprone-integer-division): a grid
  return points;
}

TEST(DegenerateClouds, ManyPointsAtOnePlaceAreFoundAsQuicklyAsOthers) {
  Points points(1'000'000, Eigen::Vector3f(1, 2, 3));
  const KdTree tree(points);
  std::vector<Neighbour> found;
  for (const auto& p : points) {
    tree.nearest_k(p, 4, found);
    ASSERT_EQ(found.size(), 4U);
    ASSERT_EQ(found.back().squared_m, 0);
  }
}

TEST(DegenerateClouds, NoReturnsSentAsZerosLeaveTheRestOfTheCloud) {
  Points points = wall(5, 60);
  const std::size_t with_walls = prepare(one_sweep(points)).points.size();
  ASSERT_GT(with_walls, 100U);
  points.resize(200'000, Eigen::Vector3f::Zero());
  const PreparedCloud prepared = prepare(one_sweep(points));
  EXPECT_GE(prepared.points.size(), with_walls);
}

TEST(DegenerateClouds, AsManyPointsAsTheWireAllowsAtOnePlace) {
  EXPECT_TRUE(prepare(one_sweep(Points(most_decoded, Eigen::Vector3f(1, 1, 1)))).points.empty());
  EXPECT_TRUE(prepare(one_sweep(Points(most_decoded, Eigen::Vector3f::Zero()))).points.empty());
}

TEST(DegenerateClouds, APointInEveryCubeOfAHugeSpaceGivesNoMoreThanALidarSees) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> u(-40, 40);
  Points points(most_decoded / 2);
  for (auto& p : points) p = {u(rng), u(rng), u(rng)};
  EXPECT_LE(prepare(one_sweep(std::move(points))).points.size(), 131072U);
}

TEST(DegenerateClouds, SweepsFromNowhereAndPointsBeyondAllSightAreLeftOut) {
  KeyframeCloud cloud = one_sweep(wall(5, 60));
  const std::size_t sound = prepare(cloud).points.size();
  for (const float far : {1e3F, 1e7F, 1e13F, NAN, INFINITY}) {
    cloud.sweeps.insert(cloud.sweeps.begin(), Sweep{Eigen::Vector3f(far, -far, far), wall(4, 30)});
    for (auto& p : wall(far, 10)) cloud.sweeps.back().points.push_back(p);
  }
  const PreparedCloud prepared = prepare(cloud);
  EXPECT_EQ(prepared.points.size(), sound);
  EXPECT_EQ(prepared.views->size(), 1U);
}

TEST(DegenerateClouds, OfTooManySweepsTheLastAreTaken) {
  KeyframeCloud cloud;
  for (int i = 0; i < 256; ++i) cloud.sweeps.push_back({Eigen::Vector3f(0.1F * static_cast<float>(i), 0, 0), {}});
  const PreparedCloud prepared = prepare(cloud);
  ASSERT_EQ(prepared.views->size(), 64U);
  EXPECT_EQ(prepared.views->back().origin, cloud.sweeps.back().origin);
}

}  // namespace
}  // namespace headframe
