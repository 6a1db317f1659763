#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "server/verification/free_space.hpp"
#include "tests/support/placed_clouds.hpp"

namespace headframe {
namespace {

using test::BoxMine;
using test::placed;

TEST(SurfelCloud, StrayReturnsAreLeftOut) {
  const BoxMine drift({BoxMine::drift(-20, 0, 20, 0)});
  std::mt19937 rng(1);
  Sweep sweep{Eigen::Vector3f::Zero(), drift.scan(pose_from_yaw(0, {0, 0, 1}), rng, 0.01, 32, 512)};
  const std::size_t clean = prepare({{sweep}}).points.size();
  std::uniform_real_distribution<float> inside(-1.5F, 1.5F);
  for (int i = 0; i < 60; ++i) sweep.points.emplace_back(4 * inside(rng), inside(rng), 0.3F * inside(rng));
  const PreparedCloud dusty = prepare({{sweep}});
  EXPECT_NEAR(static_cast<double>(dusty.points.size()), static_cast<double>(clean), 0.01 * static_cast<double>(clean));
  EXPECT_EQ(dusty.points.size(), dusty.normals.size());
  sweep.points = {{std::nanf(""), 0, 0}, {1e9F, 0, 0}, {1, 1, std::numeric_limits<float>::infinity()}};
  EXPECT_TRUE(prepare({{sweep}}).points.empty());
}

TEST(SurfelCloud, HoweverManyStraysThereAreNothingElseIsLost) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> beside(-0.1F, 0.1F);
  const auto at = [](int i) { return Eigen::Vector3f(3, 1.2F * static_cast<float>(i), 0); };
  Points fours, strays;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 4; ++k) fours.push_back(at(i % 30) + Eigen::Vector3f(i < 30 ? 0 : 3, beside(rng), beside(rng)));
  for (int i = 0; i < 400; ++i) {  // farther apart than 8 % of their range
    const int ring = i / 50;
    const float turn = 0.115F * static_cast<float>(i % 50), rise = 0.1F * static_cast<float>(ring) - 0.4F;
    strays.emplace_back(-60 * std::cos(turn) * std::cos(rise), -60 * std::sin(turn) * std::cos(rise),
                        60 * std::sin(rise));
  }
  const PreparedCloud clean = prepare({{{Eigen::Vector3f::Zero(), fours}}});
  ASSERT_GT(clean.points.size(), 60U);
  for (const std::size_t count : {1U, 200U, 400U})
    for (const bool scattered : {false, true}) {
      Points all(strays.begin(), strays.begin() + static_cast<std::ptrdiff_t>(count));
      for (std::size_t i = 0; i < fours.size(); ++i)
        all.insert(scattered ? all.begin() + static_cast<std::ptrdiff_t>(i * (all.size() / fours.size())) : all.end(),
                   fours[i]);
      EXPECT_EQ(prepare({{{Eigen::Vector3f::Zero(), all}}}).points.size(), clean.points.size()) << count << scattered;
    }
}

TEST(SurfelCloud, SpheresHoldEveryCubeOfTheirClouds) {
  const BoxMine drift({BoxMine::drift(-20, 0, 20, 0), BoxMine::drift(0, -20, 0, 20)});
  const auto clouds = placed(drive(drift, {{-9, 0}, {9, 0}}, 0.4, 1, 2));
  const Eigen::Vector3d centre = clouds[4].T_local_sensor.translation();
  constexpr float radius_m = 7, leaf_m = 0.4F;
  const auto cube = [&](const Eigen::Vector3f& p) {
    return std::array{std::floor(p.x() / leaf_m), std::floor(p.y() / leaf_m), std::floor(p.z() / leaf_m)};
  };
  std::set<std::array<float, 3>> cubes;
  for (const PlacedCloud& cloud : clouds)
    for (const Eigen::Vector3f& p : cloud.cloud->points) {
      const Eigen::Vector3f moved =
          cloud.T_local_sensor.linear().cast<float>() * p + (cloud.T_local_sensor.translation() - centre).cast<float>();
      if (moved.squaredNorm() <= radius_m * radius_m) cubes.insert(cube(moved));
    }
  EXPECT_GT(cubes.size(), 500U);
  EXPECT_NEAR(static_cast<double>(sphere(clouds, centre, radius_m, leaf_m).points.size()),
              static_cast<double>(cubes.size()), 1)
      << "a point on a cube's face may be rounded to either side";
}

TEST(SurfelCloud, SpheresHoldTheirPointsOnceEach) {
  const BoxMine drift({BoxMine::drift(-20, 0, 20, 0)});
  const auto d = drive(drift, {{-6, 0}, {6, 0}}, 0, 1, 2);
  const Eigen::Vector3d centre = d.keyframes[2].T_local_sensor.translation();
  const SurfelCloud submap = sphere(placed(d), centre, 5, 0.5F);
  ASSERT_GT(submap.points.size(), 100U);
  std::set<std::array<int, 3>> cubes;
  for (const auto& p : submap.points) {
    const Eigen::Vector3f relative = p - centre.cast<float>();
    EXPECT_LT(relative.norm(), 5.001F);
    const Eigen::Vector3i c = (relative / 0.5F).array().floor().cast<int>();
    EXPECT_TRUE(cubes.insert({c.x(), c.y(), c.z()}).second);
  }
}

TEST(Visibility, AVehicleThatDroveOnIsTransient) {
  const BoxMine drift({BoxMine::drift(-20, 0, 20, 0)});
  auto d = drive(drift, {{-6, 0}, {6, 0}}, 0, 1, 2);
  for (int y = 0; y < 20; ++y)  // one keyframe sees a vehicle 4 m ahead that none of the others does
    for (int z = 0; z < 20; ++z)
      d.clouds[1].sweeps[0].points.emplace_back(4, -0.5F + 0.05F * static_cast<float>(y),
                                                -0.5F + 0.05F * static_cast<float>(z));
  const auto clouds = placed(d);
  const Eigen::Vector3d vehicle = d.keyframes[1].T_local_sensor * Eigen::Vector3d(4, 0, 0);
  const auto nearest = [&](const SurfelCloud& submap) {
    double distance = 1e9;
    for (const auto& p : submap.points) distance = std::min(distance, (p.cast<double>() - vehicle).norm());
    return distance;
  };
  const SurfelCloud all = sphere(clouds, vehicle, 6, 0.3F);
  EXPECT_LT(nearest(all), 0.6);
  EXPECT_GT(nearest(without_transients(all, views_near(clouds, vehicle, 20), 20)), 0.6);
}

TEST(Visibility, TheRightPlaceHasNoViolationsAndAWrongOneHas) {
  const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30)});
  const auto a = drive(mine, {{5, 0}, {45, 0}}, 0, 1), b = drive(mine, {{30, 25}, {30, 0}, {15, 0}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const Eigen::Vector3d crossing = b.T_mine_local.inverse() * Eigen::Vector3d(30, 0, 1);
  const SurfelCloud rock = sphere(placed(b), crossing, 15, 0.5F);
  const auto clouds_a = placed(a);
  const auto views = views_near(clouds_a, truth * crossing, 25);
  EXPECT_LT(look_from(views, rock, truth, 25, 0.5F).violation(), 0.002);
  EXPECT_GT(look_from(views, rock, Eigen::Translation3d(0, 6, 0) * truth, 25, 0.5F).violation(), 0.02);
}

TEST(Visibility, FewPointsProveLittleAndManyAsMuchAsTheirShare) {
  constexpr double contradicts = 0.015;
  EXPECT_EQ(Visibility{}.violation(), 0);
  EXPECT_LT((Visibility{.seen = 44, .violated = 2}).violation(), contradicts);
  EXPECT_GT((Visibility{.seen = 0, .violated = 2}).violation(), contradicts);  // nothing agrees
  EXPECT_GT((Visibility{.seen = 40, .violated = 5}).violation(), contradicts);
  EXPECT_NEAR((Visibility{.seen = 9800, .violated = 200}).violation(), 0.02, 2e-4);
}

/// A drive's sweeps, every second keyframe of them laid two metres off, and another's rock, which some hit and some see
/// through.
struct RockSeen {
  static constexpr float reach_m = 20;
  std::vector<PlacedCloud> clouds_a;
  std::vector<PlacedView> views;
  SurfelCloud rock;
  Pose T_a_b;

  RockSeen() {
    const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30)});
    const auto a = drive(mine, {{5, 0}, {45, 0}}, 0, 1), b = drive(mine, {{30, 25}, {30, 0}, {15, 0}}, 1, 2);
    T_a_b = a.T_mine_local.inverse() * b.T_mine_local;
    const Eigen::Vector3d crossing = b.T_mine_local.inverse() * Eigen::Vector3d(30, 0, 1);
    rock = sphere(placed(b), crossing, 15, 0.5F);
    clouds_a = placed(a);
    for (std::size_t i = 0; i < clouds_a.size(); i += 2) clouds_a[i].T_local_sensor.translation().y() += 2;
    views = views_near(clouds_a, T_a_b * crossing, 25);
  }

  /// How many of the first eight sweeps that know anything of it hit the point, and how many see through it.
  std::pair<int, int> answers(std::size_t i) const {
    int hits = 0, through = 0;
    for (const PlacedView& view : views) {
      if (hits + through == 8) break;
      const Pose T_b_view = T_a_b.inverse() * view.T_local_view;
      const Eigen::Vector3f ray = rock.points[i] - T_b_view.translation().cast<float>();
      if (ray.norm() > reach_m) continue;
      const Sight sight = view.image->look(T_b_view.inverse().cast<float>() * rock.points[i], reach_m);
      hits += sight == Sight::hit;
      through += sight == Sight::through && std::abs(rock.normals[i].dot(ray)) > 0.3F * ray.norm();
    }
    return {hits, through};
  }
};

TEST(Visibility, SightsAreThoseOfOnePointAfterAnother) {
  const RockSeen at;
  const std::vector<PointSight> sights = sights_from(at.views, at.rock, at.T_a_b, RockSeen::reach_m, 0.5F);
  ASSERT_EQ(sights.size(), at.rock.points.size());
  std::array<int, 3> seen{};
  int ties = 0;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const auto [hits, through] = at.answers(i);
    const PointSight expected = hits + through == 0 ? PointSight::unknown
                                : through > hits    ? PointSight::violated
                                                    : PointSight::seen;
    EXPECT_EQ(sights[i] == PointSight::lone ? PointSight::violated : sights[i], expected) << i;
    ++seen.at(static_cast<std::size_t>(expected));
    ties += hits == 4 && through == 4;
  }
  for (const int of_each : seen) EXPECT_GT(of_each, 20);
  EXPECT_GT(ties, 5);
}

TEST(Visibility, WhatIsTransientIsToldByTheSameSweepsOfOnePointAfterAnother) {
  const RockSeen at;
  SurfelCloud laid;  // as if the sweeps were its own session's
  for (std::size_t i = 0; i < at.rock.points.size(); ++i) {
    laid.points.emplace_back((at.T_a_b * at.rock.points[i].cast<double>()).cast<float>());
    laid.normals.emplace_back(at.T_a_b.linear().cast<float>() * at.rock.normals[i]);
  }
  std::vector<std::size_t> kept;
  int ties = 0;
  for (std::size_t i = 0; i < laid.points.size(); ++i) {
    const auto [hits, through] = at.answers(i);
    if (!is_transient(hits, through, 2)) kept.push_back(i);
    ties += hits == 4 && through == 4;
  }
  const SurfelCloud found = without_transients(laid, at.views, RockSeen::reach_m);
  ASSERT_EQ(found.points.size(), kept.size());
  for (std::size_t k = 0; k < kept.size(); ++k) EXPECT_EQ(found.points[k], laid.points[kept[k]]);
  EXPECT_GT(kept.size(), 100U);
  EXPECT_LT(kept.size() + 100, laid.points.size());
  EXPECT_GT(ties, 5);
}

TEST(Visibility, ARayThatGrazesASurfaceSaysNothing) {
  const BoxMine drift({BoxMine::drift(-40, 0, 40, 0, 6)});
  std::mt19937 rng(1);
  const SightImage image(drift.scan(pose_from_yaw(0, {0, 0, 1}), rng, 0, 64, 720));
  const PlacedView view{pose_from_yaw(0, {0, 0, 1}), std::make_shared<const SightImage>(image)};
  const auto patch = [](const Eigen::Vector3f& normal) {  // 10 m ahead, in the free middle of the drift
    SurfelCloud out;
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z) {
        out.points.emplace_back(10, 0.4F * static_cast<float>(y) - 0.6F, 0.6F + 0.2F * static_cast<float>(z));
        out.normals.push_back(normal);
      }
    return out;
  };
  const auto violated = [&](const Eigen::Vector3f& n) {
    return look_from(std::span(&view, 1), patch(n.normalized()), Pose::Identity(), 25, 0.5F).violated;
  };
  EXPECT_EQ(violated({1, 0, 0}), 16);
  EXPECT_EQ(violated({0.36F, 0, 0.93F}), 16);
  EXPECT_EQ(violated({0.2F, 0, 0.98F}), 0);
}

}  // namespace
}  // namespace headframe
