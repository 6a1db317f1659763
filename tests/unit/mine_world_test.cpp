#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/mine/lattice.hpp"
#include "tests/mine/rock.hpp"
#include "tests/mine/route.hpp"
#include "tests/mine/scenario.hpp"

namespace headframe::mine {
namespace {

Plan corridor(double width_m) {
  Plan plan;
  plan.nodes = {{0, 0, 0}, {40, 0, 0}};
  add_drift(plan, 0, 1, 0, width_m, 4);
  plan.roughness = 0;
  return plan;
}

bool same(const Mesh& a, const Mesh& b) { return a.vertices == b.vertices && a.triangles == b.triangles; }

TEST(World, TheSameSeedGivesTheSameMine) {
  const LatticeStyle style{.columns = 2, .rows = 2, .jitter_m = 3, .bend = 0.1};
  const auto build = [&](std::uint64_t seed) {
    Plan plan = lattice_plan(style, Rng(seed));
    furnish(plan, Rng(seed));
    plan.rock_seed = seed;
    return mesh_of(plan);
  };
  const Mesh first = build(4);
  EXPECT_FALSE(first.triangles.empty());
  EXPECT_TRUE(same(first, build(4)));
  EXPECT_FALSE(same(first, build(5)));
}

TEST(World, SmoothDriftsHaveTheWidthAndHeightOfThePlan) {
  const RayCaster caster(mesh_of(corridor(5)));
  for (const float x : {10.03F, 17.4F, 26.9F}) {
    const Eigen::Vector3f eye(x, 0, 1.5);
    const auto left = caster.cast(eye, {0, 1, 0}, 50), right = caster.cast(eye, {0, -1, 0}, 50);
    const auto up = caster.cast(eye, {0, 0, 1}, 50), down = caster.cast(eye, {0, 0, -1}, 50);
    ASSERT_TRUE(left && right && up && down);
    EXPECT_NEAR(left->range_m, 2.5, 0.05);
    EXPECT_NEAR(right->range_m, 2.5, 0.05);
    EXPECT_NEAR(up->range_m, 2.5, 0.1);
    EXPECT_NEAR(down->range_m, 1.5, 0.05);
  }
}

TEST(World, MeshesAreClosed) {
  const RayCaster caster(mesh_of(corridor(5)));
  Rng rng(1);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3f direction =
        Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized().cast<float>();
    EXPECT_TRUE(caster.cast({20, 0, 1.5}, direction, 100)) << direction.transpose();
  }
}

TEST(World, EveryKindIsConnectedAndOpenAlongItsDrifts) {
  for (const Kind kind : {Kind::junctions, Kind::grid, Kind::room_and_pillar, Kind::ramp, Kind::straight,
                          Kind::look_alike, Kind::varied, Kind::tiled_cave}) {
    const Plan plan = make_plan(kind, 2);
    std::set<std::size_t> reached{0};
    for (std::size_t before = 0; before != reached.size();) {
      before = reached.size();
      for (const Drift& drift : plan.drifts)
        if (reached.contains(drift.a) || reached.contains(drift.b)) reached.insert({drift.a, drift.b});
    }
    EXPECT_EQ(reached.size(), plan.nodes.size()) << to_string(kind);
    const Rock rock(plan);
    for (const Drift& drift : plan.drifts)
      for (const auto& p : drift.line)
        EXPECT_LT(rock.depth_m(p + Eigen::Vector3d(0, 0, 0.6 * drift.height_m)), -0.3)
            << to_string(kind) << " at " << p.transpose();
  }
}

TEST(World, TilesOfOnePieceAreCopiesAtAnyHeading) {
  const Plan plan = make_plan(Kind::tiled_cave, 3);
  const Rock rock(plan);
  const auto& pieces = plan.tiling->pieces;
  const auto at = [&](std::size_t tile, Eigen::Vector3d own) {  // a place in the tile's own axes
    for (int k = 0; k < pieces[tile].quarter_turns; ++k) own = Eigen::Vector3d(-own.y(), own.x(), own.z());
    return rock.depth_m(plan.nodes[tile] + own);
  };
  Rng rng(1);
  double other_pieces = 0;
  for (std::size_t tile = 10; tile < 14; ++tile)  // none of them at the mine's edge, where a tunnel ends
    for (std::size_t other = 17; other < 22; ++other)
      for (int i = 0; i < 50; ++i) {
        const Eigen::Vector3d own(rng.uniform(-6, 6), rng.uniform(-6, 6), rng.uniform(0.5, 3));
        const double differ = std::abs(at(tile, own) - at(other, own));
        if (pieces[tile].number == pieces[other].number)
          EXPECT_LT(differ, 0.09);
        else
          other_pieces = std::max(other_pieces, differ);
      }
  EXPECT_GT(other_pieces, 1);
}

TEST(World, KindsAreKnownByName) {
  EXPECT_EQ(kind_of("look_alike"), Kind::look_alike);
  EXPECT_EQ(to_string(Kind::room_and_pillar), "room_and_pillar");
  EXPECT_FALSE(kind_of("quarry"));
}

TEST(Route, FollowsTheNodesAtEqualSteps) {
  Plan plan;
  plan.nodes = {{0, 0, 0}, {10, 0, 0}, {10, 20, 0}};
  add_drift(plan, 1, 0, 0, 4, 3);  // against the way
  add_drift(plan, 1, 2, 0, 4, 3);
  const Route route = route_through(plan, {0, 1, 2}, 2, 100);
  EXPECT_NEAR(length_m(route), 28, 0.5);
  EXPECT_LT((route.front() - Eigen::Vector3d(2, 0, 0)).norm(), 1e-9);
  EXPECT_LT((route.back() - Eigen::Vector3d(10, 20, 0)).norm(), route_step_m);
  EXPECT_NEAR(length_m(route_through(plan, {0, 1, 2}, 2, 12)), 12, route_step_m);
}

TEST(Route, SharedPartCountsWhatIsNear) {
  Route a, b;
  for (int i = 0; i < 100; ++i) a.emplace_back(i, 0, 0), b.emplace_back(i + 50, 3, 0);
  EXPECT_NEAR(shared_part(a, b, 3.001), 0.5, 1e-9);
  EXPECT_EQ(shared_part(a, b, 2.999), 0);
}

}  // namespace
}  // namespace headframe::mine
