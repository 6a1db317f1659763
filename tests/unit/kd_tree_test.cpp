#include "server/registration/kd_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace headframe {
namespace {

Points random_points(std::size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> u(-10, 10);
  Points points(n);
  for (auto& p : points) p = {u(rng), u(rng), 0.1F * u(rng)};
  return points;
}

std::vector<Neighbour> brute_force(const Points& points, const Eigen::Vector3f& query) {
  std::vector<Neighbour> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) all.push_back({i, (points[i] - query).squaredNorm()});
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.squared_m < b.squared_m || (a.squared_m == b.squared_m && a.index < b.index);
  });
  return all;
}

TEST(KdTree, AgreesWithBruteForce) {
  Points points = random_points(3000, 1);
  for (int i = 0; i < 200; ++i) points.push_back(points[static_cast<std::size_t>(i % 5)]);  // many at one place
  const KdTree tree(points);
  std::vector<Neighbour> found;
  for (const auto& query : random_points(200, 2)) {
    const auto oracle = brute_force(points, query);
    tree.nearest_k(query, 20, found);
    ASSERT_EQ(found.size(), 20U);
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k].index, oracle[k].index);
    Neighbour one;
    ASSERT_TRUE(tree.nearest(query, 100, one));
    EXPECT_EQ(one.index, oracle[0].index);
  }
}

TEST(KdTree, CountsWithinAReachAsBruteForceDoes) {
  Points points = random_points(500, 3);
  for (int i = 0; i < 20; ++i) points.push_back(points[0]);  // many at one place
  const KdTree tree(points);
  int yes = 0, no = 0;
  for (const auto& query : random_points(300, 4)) {
    const auto oracle = brute_force(points, query);
    for (const std::size_t count : {1, 4, 17, 60}) {
      const float nearest_m = std::sqrt(oracle[count - 1].squared_m);
      for (const float reach_m : {0.5F, 1.5F, 4.0F, 0.999F * nearest_m, 1.001F * nearest_m}) {
        const bool expected = oracle[count - 1].squared_m < reach_m * reach_m;
        EXPECT_EQ(tree.has_within(query, reach_m, count), expected) << count << " within " << reach_m;
        ++(expected ? yes : no);
      }
    }
  }
  EXPECT_GT(yes, 1000);
  EXPECT_GT(no, 1000);
  EXPECT_TRUE(tree.has_within(points[0], 0.01F, 21)) << "itself and all at its place";
  EXPECT_FALSE(tree.has_within(points[0], 0.01F, 22));
  EXPECT_FALSE(tree.has_within({0, 0, 0}, 1000, 521)) << "there are no more than 520";
}

TEST(KdTree, ReachIsExclusive) {
  const KdTree tree(Points{{2, 0, 0}});
  Neighbour n;
  EXPECT_FALSE(tree.nearest({0, 0, 0}, 2.0F, n));
  EXPECT_TRUE(tree.nearest({0, 0, 0}, 2.001F, n));
  EXPECT_FALSE(tree.has_within({0, 0, 0}, 2.0F, 1));
  EXPECT_TRUE(tree.has_within({0, 0, 0}, 2.001F, 1));
}

TEST(KdTree, HoldsNothingOrLittle) {
  std::vector<Neighbour> found;
  Neighbour n;
  EXPECT_FALSE(KdTree(Points{}).nearest({0, 0, 0}, 10, n));
  KdTree(Points{{1, 0, 0}, {2, 0, 0}}).nearest_k({0, 0, 0}, 5, found);
  EXPECT_EQ(found.size(), 2U);
}

}  // namespace
}  // namespace headframe
