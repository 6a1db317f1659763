// Points of many keyframes in one region: against brute force, and both sides of each limit.
#include "server/surroundings/map_region.hpp"

#include <gtest/gtest.h>

#include <random>

namespace headframe {
namespace {

const MapLimits limits;
const auto go_on = [] { return false; };

TEST(MapRegion, BothSidesOfEachLimit) {
  EXPECT_EQ(objection(SphereRegion{{0, 0, 0}, 200}, 0.2, limits), "");
  EXPECT_NE(objection(SphereRegion{{0, 0, 0}, 200.1}, 0.2, limits), "");
  EXPECT_NE(objection(SphereRegion{{0, 0, 0}, 0}, 0.2, limits), "");
  EXPECT_NE(objection(SphereRegion{{NAN, 0, 0}, 1}, 0.2, limits), "");
  EXPECT_NE(objection(SphereRegion{{0, 0, 0}, NAN}, 0.2, limits), "");
  EXPECT_EQ(objection(BoxRegion{{0, 0, 0}, {400, 1, 1}}, 0.2, limits), "");
  EXPECT_NE(objection(BoxRegion{{0, 0, 0}, {400.1, 1, 1}}, 0.2, limits), "");
  EXPECT_NE(objection(BoxRegion{{0, 0, 0}, {1, 1, 0}}, 0.2, limits), "");
  EXPECT_EQ(objection(SphereRegion{{0, 0, 0}, 1}, 0.05, limits), "");
  EXPECT_NE(objection(SphereRegion{{0, 0, 0}, 1}, 0.049, limits), "");
  EXPECT_EQ(objection(SphereRegion{{0, 0, 0}, 1}, 5, limits), "");
  EXPECT_NE(objection(SphereRegion{{0, 0, 0}, 1}, 5.1, limits), "");
  EXPECT_NE(objection(SphereRegion{{0, 0, 0}, 1}, NAN, limits), "");
}

TEST(MapRegion, ReadsTheNewestCloudsThatAreNearEnough) {
  MapLimits few = limits;
  few.clouds = 2;
  std::vector<RegionCloud> all;
  for (std::uint64_t i = 1; i <= 4; ++i) all.push_back({{1, i}, static_cast<double>(i), pose_from_yaw(0, {0, 0, 0})});
  all.push_back({{2, 1}, 100, pose_from_yaw(0, {29.9, 0, 0})});
  all.push_back({{2, 2}, 100, pose_from_yaw(0, {30.1, 0, 0})});
  std::size_t left_out = 0;
  const auto near = clouds_near(all, SphereRegion{{0, 0, 0}, 10}, few, left_out);
  ASSERT_EQ(near.size(), 2U);
  EXPECT_EQ(near[0].keyframe, (KeyframeRef{2, 1}));
  EXPECT_EQ(near[1].keyframe, (KeyframeRef{1, 4}));
  EXPECT_EQ(left_out, 3U);
}

struct Drawn {
  std::vector<RegionCloud> clouds;
  std::map<KeyframeRef, KeyframeCloud> points;
  Result<KeyframeCloud> read(const KeyframeRef& k) const {
    const auto found = points.find(k);
    if (found == points.end()) return failure(ErrorCode::not_found, "none");
    return found->second;
  }
};

Drawn drawn() {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> anywhere(-8, 8);
  Drawn out;
  for (std::uint64_t i = 1; i <= 5; ++i) {
    const double k = static_cast<double>(i);
    out.clouds.push_back({{1, i}, k, pose_from_yaw(k, {k, -k, 0.5 * k})});
    KeyframeCloud cloud{{Sweep{}, Sweep{}}};
    for (int p = 0; p < 2000; ++p)
      cloud.sweeps[static_cast<std::size_t>(p % 2)].points.emplace_back(anywhere(random), anywhere(random),
                                                                        anywhere(random));
    out.points[{1, i}] = cloud;
  }
  return out;
}

TEST(MapRegion, EveryCubeHasTheMeanOfItsPointsAndNothingLiesOutside) {
  const Drawn all = drawn();
  const double edge_m = 1;
  for (const Region& region : {Region(SphereRegion{{1, 2, 0.5}, 5}), Region(BoxRegion{{-3, -4, 0}, {5, 2, 3}})}) {
    const auto fused = fuse(
        all.clouds, region, edge_m, limits, [&](const KeyframeRef& k) { return all.read(k); }, go_on);
    ASSERT_TRUE(fused);
    EXPECT_EQ(fused->clouds, 5U);
    std::map<std::array<long, 3>, std::pair<Eigen::Vector3d, int>> cubes;
    for (const RegionCloud& c : all.clouds)
      for (const Sweep& sweep : all.points.at(c.keyframe).sweeps)
        for (const Eigen::Vector3f& p : sweep.points) {
          const Eigen::Vector3d at = c.T_region_sensor * p.cast<double>();
          if (distance_m(region, at) > 0) continue;
          const Eigen::Vector3d rel = at - middle_m(region);
          auto& cube = cubes
                           .try_emplace({std::lround(std::floor(rel.x())), std::lround(std::floor(rel.y())),
                                         std::lround(std::floor(rel.z()))},
                                        Eigen::Vector3d::Zero(), 0)
                           .first->second;
          cube.first += rel;
          ++cube.second;
        }
    ASSERT_EQ(fused->points.size(), cubes.size());
    for (const Eigen::Vector3f& p : fused->points) {
      const auto& cube =
          cubes.at({std::lround(std::floor(p.x())), std::lround(std::floor(p.y())), std::lround(std::floor(p.z()))});
      EXPECT_NEAR((p.cast<double>() - cube.first / cube.second).norm(), 0, 1e-5);
    }
  }
}

TEST(MapRegion, MorePointsThanMayBeAreRefusedAndAsManyAsMayBeAreNot) {
  const Drawn all = drawn();
  const Region region = SphereRegion{{1, 2, 0.5}, 5};
  const auto read = [&](const KeyframeRef& k) { return all.read(k); };
  const std::size_t points = fuse(all.clouds, region, 1, limits, read, go_on)->points.size();
  MapLimits tight = limits;
  tight.points = points;
  EXPECT_TRUE(fuse(all.clouds, region, 1, tight, read, go_on));
  tight.points = points - 1;
  const auto refused = fuse(all.clouds, region, 1, tight, read, go_on);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(refused.error().message.find("coarser"), std::string::npos);
}

TEST(MapRegion, ACloudThatCanNotBeReadIsLeftOutAndAStopEndsIt) {
  Drawn all = drawn();
  all.points.erase({1, 3});
  const auto read = [&](const KeyframeRef& k) { return all.read(k); };
  const Region region = SphereRegion{{0, 0, 0}, 20};
  EXPECT_EQ(fuse(all.clouds, region, 1, limits, read, go_on)->clouds, 4U);
  EXPECT_FALSE(fuse(all.clouds, region, 1, limits, read, [] { return true; }));
}

}  // namespace
}  // namespace headframe
