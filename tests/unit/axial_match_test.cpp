#include "server/verification/axial_match.hpp"

#include <gtest/gtest.h>

#include "server/registration/surfels.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::Box;
using test::BoxMine;

/// What a robot sees of a drift along x from three places.
Surfels seen_of(const BoxMine& mine, unsigned seed) {
  std::mt19937 rng(seed);
  Points all;
  for (const double x : {-6.0, 0.0, 6.0}) {
    const Pose T = pose_from_yaw(0, {x, 0.1, 1.2});
    for (const auto& p : mine.scan(T, rng)) all.emplace_back((T * p.cast<double>()).cast<float>());
  }
  return make_surfels(voxel_grid(all, 0.2F));
}

struct Pair {
  VoxelMaps target;
  Surfels source;
  std::vector<VgicpPair> pairs() const { return {{&target, &source.points, &source.normals}}; }
};

Pair pair_of(const BoxMine& a, const BoxMine& b) {
  const Surfels seen = seen_of(a, 1);
  return {make_voxel_maps(seen.points, seen.normals), seen_of(b, 2)};
}

Pose slid(double x) { return pose_from_yaw(0, {x, 0, 0}); }
const Eigen::Vector3d along = Eigen::Vector3d::UnitX();

const Box drift = BoxMine::drift(-60, 0, 60, 0);
const BoxMine with_niche({drift, BoxMine::drift(3, 0, 3, 5, 3, 2.5)});

TEST(AxialSurfaces, TheirMeetingTellsHowFarADriftHasSlid) {
  const Pair p = pair_of(with_niche, with_niche);
  for (const double off_m : {-2.4, -0.3, 1.25, 3.0}) {
    const AxialSurfaces surfaces(p.pairs(), slid(off_m), along);
    EXPECT_NEAR(surfaces.best_slide_m(4), -off_m, 0.13) << off_m;
    EXPECT_GT(surfaces.match(-off_m), 0.5);
    EXPECT_LT(surfaces.match(-off_m + 0.7), 0.12);
  }
}

TEST(AxialSurfaces, WhereNothingIsOutOfPlaceNothingSlides) {
  const Pair p = pair_of(with_niche, with_niche);
  EXPECT_EQ(AxialSurfaces(p.pairs(), slid(0), along).best_slide_m(4), 0);
  EXPECT_EQ(AxialSurfaces(p.pairs(), slid(3), along).best_slide_m(2), 0) << "beyond the reach";
}

TEST(AxialSurfaces, ANicheThatTheOtherHasNotMatchesNowhere) {
  const Pair p = pair_of(BoxMine({drift}), with_niche);
  const AxialSurfaces surfaces(p.pairs(), slid(0), along);
  for (int k = -8; k <= 8; ++k) EXPECT_LT(surfaces.match(0.5 * k), 0.1) << k;
}

}  // namespace
}  // namespace headframe
