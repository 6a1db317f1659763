#include "tests/mine/open_directions.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/mine/lattice.hpp"

namespace headframe::mine {
namespace {

/// 180 sectors of 2 m, but for runs of 30 m: {first sector, sectors}.
int ways(const std::vector<std::pair<std::size_t, std::size_t>>& open) {
  std::vector<double> range_m(180, 2);
  for (const auto& [first, wide] : open)
    for (std::size_t i = 0; i < wide; ++i) range_m[(first + i) % 180] = 30;
  return open_directions(range_m);
}

TEST(OpenDirections, CountsRunsThatAreWideAndApartEnough) {
  EXPECT_EQ(ways({}), 0);
  EXPECT_EQ(ways({{10, 3}}), 1);
  EXPECT_EQ(ways({{10, 2}}), 0) << "4 deg are a crack";
  EXPECT_EQ(ways({{10, 5}, {100, 5}}), 2);
  EXPECT_EQ(ways({{10, 5}, {17, 5}, {100, 5}}), 3);
  EXPECT_EQ(ways({{10, 5}, {16, 5}, {100, 5}}), 2) << "2 deg between two runs: a pillar of a hand's width";
  EXPECT_EQ(ways({{177, 6}, {90, 6}}), 2) << "a run through azimuth 0 is one";
  EXPECT_EQ(ways({{0, 180}}), 0) << "as far everywhere as at the sides: a hall";
}

TEST(OpenDirections, FarIsFourTimesTheRoomAtTheSides) {
  const auto room = [](double side_m, double far_m) {
    std::vector<double> range_m(180, side_m);
    std::fill_n(range_m.begin() + 20, 6, far_m);
    return open_directions(range_m);
  };
  EXPECT_EQ(room(2, 8.1), 1);
  EXPECT_EQ(room(2, 7.9), 0);
  EXPECT_EQ(room(1, 6.1), 1);
  EXPECT_EQ(room(1, 5.9), 0) << "six metres at least";
}

TEST(OpenDirections, ACrossingHasFourADriftTwoADeadEndOne) {
  Plan plan;
  plan.nodes = {{-30, 0, 0}, {0, 0, 0}, {30, 0, 0}, {0, 30, 0}, {0, -30, 0}};
  for (std::size_t k : {0, 2, 3, 4}) add_drift(plan, 1, k, 0, 4, 3);
  plan.roughness = 0;
  const RayCaster caster(mesh_of(plan));
  const auto at = [&](double x, double y) {
    Pose T = Pose::Identity();
    T.translation() = Eigen::Vector3d(x, y, 1.2);
    return open_directions(caster, T);
  };
  EXPECT_EQ(at(0, 0), 4);
  EXPECT_EQ(at(15, 0), 2);
  EXPECT_EQ(at(29, 0), 1);
}

}  // namespace
}  // namespace headframe::mine
