#include "server/registration/normal_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace headframe {
namespace {

/// Pairs at random, in double, beside the block that they were put into.
struct Pairs {
  struct Pair {
    Eigen::Vector3d q, e;
    Eigen::Matrix3d M;
  };
  std::vector<Pair> pairs;
  FactorBlock block;
};

constexpr double epsilon = 1e-2, reach_m = 2, share = 0.5;
constexpr double kernel = share * reach_m * share * reach_m / (2 * epsilon);

Eigen::Vector3f some_vector(std::mt19937& rng, float size) {
  std::normal_distribution<float> normal(0, size);
  return {normal(rng), normal(rng), normal(rng)};
}

/// Normals of both sides within some 30 deg of each other, so that all pairs count.
void fill(Pairs& out, std::size_t count, unsigned seed) {
  std::mt19937 rng(seed);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f q = some_vector(rng, 5), e = some_vector(rng, 0.2F), n_t = some_vector(rng, 1).normalized(),
                          n_s = (n_t + some_vector(rng, 0.1F)).normalized();
    out.block.add(q, e, outer(n_t), n_s);
    const Eigen::Vector3d t = n_t.cast<double>(), s = n_s.cast<double>();
    const Eigen::Matrix3d C = 2 * Eigen::Matrix3d::Identity() - (1 - epsilon) * (t * t.transpose() + s * s.transpose());
    out.pairs.push_back({q.cast<double>(), e.cast<double>(), C.inverse()});
  }
}

/// The error of a pair after the increment d about the centre.
Eigen::Vector3d moved_error(const Pairs::Pair& pair, const Vector6d& d) {
  return pair.e + (se3_exp(d) * pair.q - pair.q);
}

double cost(const Pairs& pairs, const Vector6d& d) {
  double sum = 0;
  for (const auto& pair : pairs.pairs) {
    const Eigen::Vector3d e = moved_error(pair, d);
    const double squared = e.dot(pair.M * e);
    sum += 0.5 * kernel * squared / (kernel + squared);  // Geman-McClure
  }
  return sum;
}

TEST(NormalEquations, GradientAgreesWithFiniteDifferences) {
  for (const std::size_t count : {1U, 3U, 4U, 5U, 255U, 256U}) {
    Pairs pairs;
    fill(pairs, count, 1);
    const NormalEquations sums = pairs.block.sum({epsilon, share}, reach_m);
    EXPECT_EQ(sums.inliers, static_cast<double>(count));
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = 1e-5 * Vector6d::Unit(k);
      const double gradient = (cost(pairs, step) - cost(pairs, -step)) / 2e-5;
      EXPECT_NEAR(sums.b[k], gradient, 1e-3 * (1 + sums.b.norm())) << count << " " << k;
    }
  }
}

TEST(NormalEquations, HessianAgreesWithFiniteDifferencesOfTheErrors) {
  Pairs pairs;
  fill(pairs, 200, 2);
  Matrix6d expected = Matrix6d::Zero();
  for (const auto& pair : pairs.pairs) {
    Eigen::Matrix<double, 3, 6> J;
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = 1e-5 * Vector6d::Unit(k);
      J.col(k) = (moved_error(pair, step) - moved_error(pair, -step)) / 2e-5;
    }
    const double ratio = kernel / (kernel + pair.e.dot(pair.M * pair.e));
    expected += ratio * ratio * J.transpose() * pair.M * J;
  }
  const NormalEquations sums = pairs.block.sum({epsilon, share}, reach_m);
  EXPECT_LT((sums.H - expected).norm(), 1e-3 * expected.norm());
  EXPECT_EQ(sums.H, sums.H.transpose());
}

TEST(NormalEquations, PairsWhoseNormalsDifferByOver60DegAreLeftOut) {
  const auto inliers = [](double angle_deg) {
    FactorBlock block;
    const auto angle = static_cast<float>(angle_deg * EIGEN_PI / 180);
    block.add({1, 2, 3}, {0, 0, 0.1F}, outer(Eigen::Vector3f::UnitZ()), {std::sin(angle), 0, std::cos(angle)});
    std::vector<float> distances_m;
    block.append_distances(distances_m);
    const double counted = block.sum({}, 1).inliers;
    EXPECT_EQ(static_cast<double>(distances_m.size()), counted);
    return counted;
  };
  EXPECT_EQ(inliers(59.9), 1);
  EXPECT_EQ(inliers(60.1), 0);
  EXPECT_EQ(inliers(180), 1);  // the sign of a normal says nothing
}

}  // namespace
}  // namespace headframe
