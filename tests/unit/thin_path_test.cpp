// A thinned path: nothing that was left out lies farther from it than the tolerance.
#include "server/operator/thin_path.hpp"

#include <gtest/gtest.h>

#include <random>

namespace headframe {
namespace {

Keyframe keyframe(std::uint64_t sequence, const Eigen::Vector3d& p_m) {
  Keyframe out;
  out.sequence = sequence;
  out.T_local_sensor.translation() = p_m;
  return out;
}

/// Tunnels with bends, ramps and stops, as somebody drives who does not keep quite to their middle.
std::vector<Keyframe> random_drive(unsigned seed, std::size_t count) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<Keyframe> path;
  Eigen::Vector3d p_m(0, 0, -400);
  double yaw = 0, bend = 0;
  for (std::uint64_t sequence = 1; path.size() < count; ++sequence) {
    if (sequence % 23 == 0) bend = 0.1 * noise(rng);
    yaw += bend;
    const double step_m = sequence % 41 == 0 ? 0 : 1.5 + 0.2 * noise(rng);
    p_m += step_m * Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.1 * std::sin(0.01 * static_cast<double>(sequence)));
    path.push_back(keyframe(sequence, p_m + 0.05 * Eigen::Vector3d(noise(rng), noise(rng), noise(rng))));
  }
  return path;
}

/// How far the farthest keyframe lies from where the thinned path is at its sequence.
double farthest_m(const std::vector<Keyframe>& path, const std::vector<Keyframe>& thin) {
  double most_m = 0;
  std::size_t next = 0;
  for (const Keyframe& k : path) {
    while (thin[next].sequence < k.sequence) ++next;
    const Keyframe &to = thin[next], &from = thin[next > 0 ? next - 1 : 0];
    const double span = static_cast<double>(to.sequence - from.sequence);
    const double share = span > 0 ? static_cast<double>(k.sequence - from.sequence) / span : 1;
    most_m = std::max(most_m, (position(k) - (position(from) + share * (position(to) - position(from)))).norm());
  }
  return most_m;
}

TEST(ThinPath, NoKeyframeLiesFartherOffThanTheTolerance) {
  for (unsigned seed = 1; seed <= 40; ++seed)
    for (const std::size_t count : {1U, 2U, 3U, 100U, 512U, 513U, 514U, 2000U})
      for (const double tolerance_m : {0.05, 0.25, 2.0}) {
        const auto path = random_drive(seed, count);
        const auto thin = thin_path(path, tolerance_m);
        ASSERT_EQ(thin.front().sequence, path.front().sequence);
        ASSERT_EQ(thin.back().sequence, path.back().sequence);
        ASSERT_LE(farthest_m(path, thin), tolerance_m + 1e-9) << seed << ' ' << count << ' ' << tolerance_m;
        for (const Keyframe& kept : thin) ASSERT_EQ(position(kept), position(path[kept.sequence - 1]));
        if (count >= 100 && tolerance_m >= 0.25) {
          EXPECT_LT(thin.size(), path.size() * 3 / 4) << "it is thinner, too";
        }
      }
}

TEST(ThinPath, WhatIsStraightAndEvenIsTwoEnds) {
  std::vector<Keyframe> path;
  for (std::uint64_t i = 1; i <= 300; ++i) path.push_back(keyframe(i, {2.0 * static_cast<double>(i), 1, -3}));
  EXPECT_EQ(thin_path(path, 0.25).size(), 2U);
  path[150].T_local_sensor.translation().y() += 0.24;
  EXPECT_EQ(thin_path(path, 0.25).size(), 2U) << "just within";
  path[150].T_local_sensor.translation().y() += 0.02;
  const auto thin = thin_path(path, 0.25);
  ASSERT_GE(thin.size(), 3U) << "just beyond";
  EXPECT_LE(farthest_m(path, thin), 0.25);
}

TEST(ThinPath, WhoWaitsOrTurnsBackOnTheLineIsNotLost) {
  std::vector<Keyframe> path;  // there and back along one line: no place of it lies off that line
  for (std::uint64_t i = 1; i <= 101; ++i)
    path.push_back(keyframe(i, {50.0 - std::abs(51.0 - static_cast<double>(i)), 0, 0}));
  const auto thin = thin_path(path, 0.25);
  EXPECT_EQ(thin.size(), 3U);
  EXPECT_LE(farthest_m(path, thin), 0.25);
}

TEST(ThinPath, AllStayWithoutATolerance) {
  const auto path = random_drive(7, 200);
  EXPECT_EQ(thin_path(path, 0).size(), path.size());
  EXPECT_TRUE(thin_path({}, 0.25).empty());
}

}  // namespace
}  // namespace headframe
