#include "server/registration/neighbourhood.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace headframe {
namespace {

/// A floor with a few points far off: leaves of very different size.
Points floor_and_strays(std::size_t count) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<float> u(-10, 10);
  Points points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(i % 20 == 0 ? Eigen::Vector3f(5 * u(rng), 5 * u(rng), 5 * u(rng))
                                 : Eigen::Vector3f(u(rng), u(rng), 0.02F * u(rng)));
  return points;
}

struct Oracle {
  std::size_t count = 0;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
};

Oracle brute_force(const Points& points, const Eigen::Vector3f& query, std::size_t k) {
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < points.size(); ++i)
    by_distance.emplace_back((points[i] - query).cast<double>().squaredNorm(), i);
  std::sort(by_distance.begin(), by_distance.end());
  Oracle out;
  out.count = std::min(k, points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < out.count; ++i) mean += points[by_distance[i].second].cast<double>();
  mean /= static_cast<double>(out.count);
  for (std::size_t i = 0; i < out.count; ++i) {
    const Eigen::Vector3d d = points[by_distance[i].second].cast<double>() - mean;
    out.scatter += d * d.transpose();
  }
  return out;
}

TEST(Neighbourhood, AgreesWithBruteForce) {
  for (const std::size_t count : {5U, 16U, 17U, 20U, 33U, 2000U})
    for (const std::size_t k : {1U, 6U, 20U, 40U}) {
      const Points points = floor_and_strays(count);
      const KdTree tree(points);
      NeighbourhoodFinder finder(tree, k);
      std::size_t seen = 0;
      for (std::size_t leaf = 0; leaf < tree.leaves().size(); ++leaf) {
        const auto around = finder.find(leaf);
        for (std::size_t i = 0; i < around.size(); ++i) {
          const std::uint32_t index = tree.leaves()[leaf].index[i];
          if (index == KdTree::nobody) continue;
          ++seen;
          const Oracle oracle = brute_force(points, points[index], k);
          ASSERT_EQ(around[i].count, static_cast<float>(oracle.count)) << count << " " << k;
          const auto& [xx, xy, xz, yy, yz, zz] = around[i].scatter;
          Eigen::Matrix3d scatter;
          scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
          ASSERT_LT((scatter - oracle.scatter).norm(), 1e-4 * (1e-3 + oracle.scatter.norm())) << count << " " << k;
        }
      }
      EXPECT_EQ(seen, count);
    }
}

TEST(Neighbourhood, PointsAsFarAsTheKthAreAllTaken) {
  Points square{{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {3, 0, 0}};
  const KdTree tree(square);
  const auto around = NeighbourhoodFinder(tree, 3).find(0);
  for (std::size_t i = 0; i < square.size(); ++i) {
    if (tree.leaves()[0].index[i] == 0U) {
      EXPECT_EQ(around[i].count, 5);
    }
  }
}

TEST(Neighbourhood, OnePlaceRepeatedEnds) {
  const Points dot(20000, Eigen::Vector3f(1, 2, 3));
  const KdTree tree(dot);
  const auto around = NeighbourhoodFinder(tree, 20).find(5);
  EXPECT_GE(around[0].count, 20);
  for (const float s : around[0].scatter) EXPECT_EQ(s, 0);
}

TEST(KdTree, ThreadsAndPointsThatAreNoPlacesChangeNothing) {
  Points points = floor_and_strays(5000);
  points[3].x() = std::numeric_limits<float>::quiet_NaN();
  points[9].y() = std::numeric_limits<float>::infinity();
  const KdTree one(points, 1), four(points, 4);
  ASSERT_EQ(one.leaves().size(), four.leaves().size());
  std::size_t seen = 0;
  for (std::size_t leaf = 0; leaf < one.leaves().size(); ++leaf) {
    EXPECT_EQ(one.leaves()[leaf].index, four.leaves()[leaf].index);
    for (const std::uint32_t index : one.leaves()[leaf].index) seen += index != KdTree::nobody;
  }
  EXPECT_EQ(seen, points.size() - 2);
}

}  // namespace
}  // namespace headframe
