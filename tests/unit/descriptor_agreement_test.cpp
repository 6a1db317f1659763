#include "server/place/descriptor_agreement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/descriptor/wall_profile.hpp"
#include "server/place/hypotheses.hpp"

namespace headframe {
namespace {

/// Keyframes every 2 m along x from x_m on; place vectors of two numbers that turn once in 37 m.
std::vector<Keyframe> drift(double x_m, std::size_t count, float scale = 1) {
  std::vector<Keyframe> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = x_m + 2 * static_cast<double>(i), turn = 2 * std::numbers::pi * x / 37;
    out[i].T_local_sensor.translation().x() = x;
    out[i].descriptor.q = {scale * static_cast<float>(std::cos(turn)), scale * static_cast<float>(std::sin(turn))};
  }
  return out;
}

TEST(DescriptorAgreement, IsGreatWhereThePathsTrulyLieAndTheUnitDoesNotMatter) {
  const auto a = drift(0, 40), b = drift(30, 40);
  const DescriptorAgreement agreement(a, b);
  const auto moved = [](double x) { return pose_from_yaw(0, {x, 0, 0}); };
  const Agreement right = agreement.at(moved(0)), wrong = agreement.at(moved(18)), apart = agreement.at(moved(200));
  EXPECT_EQ(right.count, 26) << "the last that comes within 3 m is one beyond the end";
  EXPECT_GT(right.mean(), 0.99);
  EXPECT_LT(wrong.mean(), 0.1);
  EXPECT_GT(right.support(), 10);
  EXPECT_LT(wrong.support(), -5);
  EXPECT_EQ(apart.count, 0);
  EXPECT_EQ(apart.mean(), 0);
  EXPECT_EQ(apart.cautious(), 0.5);
  const auto a_scaled = drift(0, 40, 9), b_scaled = drift(30, 40, 9);
  EXPECT_NEAR(DescriptorAgreement(a_scaled, b_scaled).at(moved(3)).mean(), agreement.at(moved(3)).mean(), 1e-5);
}

TEST(DescriptorAgreement, OfOneKeyframeSaysTheLessTheMoreCautiousOneIs) {
  const Agreement one{0.1, 1}, many{2, 20};
  EXPECT_NEAR(one.cautious(), 0.3, 1e-12);
  EXPECT_NEAR(one.cautious(3), 0.4, 1e-12);
  EXPECT_LT(many.cautious(3), 0.16) << "twenty that are as unlike do say it";
  EXPECT_EQ(Agreement().cautious(3), 0.5);
}

TEST(DescriptorAgreement, MeetsTheNearestAsBruteForceDoes) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> place(-20, 20);
  std::normal_distribution<float> value;
  const auto scattered = [&](std::size_t count, double scale) {
    std::vector<Keyframe> out(count);
    for (Keyframe& k : out) {
      k.T_local_sensor.translation() = scale * Eigen::Vector3d(place(rng), place(rng), place(rng) / 10);
      k.descriptor.q = {value(rng), value(rng), value(rng)};
    }
    return out;
  };
  for (const double scale : {1.0, 1000.0, 1e6}) {  // 1000 and more: cells that are wider than 3 m
    auto a = scattered(200, scale), b = scattered(150, 1);
    for (std::size_t i = 0; i < 50; ++i) a[i].T_local_sensor.translation() = b[i].T_local_sensor.translation();
    const DescriptorAgreement agreement(a, b);
    for (int trial = 0; trial < 20; ++trial) {
      const Pose T = pose_from_yaw(place(rng), {place(rng) / 10, place(rng) / 10, 0});
      double count = 0;
      for (const Keyframe& k : b)
        count += std::any_of(a.begin(), a.end(), [&](const Keyframe& l) {
          return (T * k.T_local_sensor.translation() - l.T_local_sensor.translation()).norm() < 3;
        });
      EXPECT_EQ(agreement.at(T).count, count);
    }
  }
}

TEST(DescriptorAgreement, SaysNothingWithoutDescriptorsOrOfOtherLengths) {
  auto a = drift(0, 10), b = drift(0, 10);
  for (Keyframe& k : b) k.descriptor.q.push_back(0);
  EXPECT_EQ(DescriptorAgreement(a, b).at(Pose::Identity()).count, 0);
  for (Keyframe& k : a) k.descriptor.q.clear();
  EXPECT_EQ(DescriptorAgreement(a, b).at(Pose::Identity()).count, 0);
  EXPECT_EQ(DescriptorAgreement({}, {}).at(Pose::Identity()).cautious(), 0.5);
}

TEST(Hypotheses, WhatTheDescriptorsProposeStaysWhereTheWallsDoNotFit) {
  // One sees walls 8 m away all around, the other stones at 2 m: each wall lies where the other saw through.
  auto a = drift(0, 40), b = drift(30, 40);
  for (auto* session : {&a, &b})
    for (Keyframe& k : *session) {
      k.walls.code.fill(encode_wall_range(session == &a ? 8 : 2));
      k.descriptor.w = {1, 0, 0, 0, 0, 0, 0, 0};
    }
  HypothesisFinder finder({});
  const auto found = finder.find({1, a}, {2, b})->hypotheses;
  const auto as_proposed = [](const Hypothesis& h) { return h.T_a_b.isApprox(Pose::Identity(), 1e-6); };
  EXPECT_EQ(std::count_if(found.begin(), found.end(), as_proposed), 1);
  HypothesisFinder forgetful({.walls_bytes = 1});  // draws walls anew whenever it needs them
  const auto again = forgetful.find({1, a}, {2, b})->hypotheses;
  EXPECT_TRUE(std::equal(again.begin(), again.end(), found.begin(), found.end(), [](const auto& g, const auto& h) {
    return g.T_a_b.matrix() == h.T_a_b.matrix() && g.score == h.score;
  }));
}

TEST(DescriptorAgreement, SessionsThatLookTheSameEverywhereAreNotCompared) {
  auto a = drift(0, 10);
  for (Keyframe& k : a) k.descriptor.q = {1, 0};
  EXPECT_EQ(DescriptorAgreement(a, a).at(Pose::Identity()).count, 0);
}

}  // namespace
}  // namespace headframe
