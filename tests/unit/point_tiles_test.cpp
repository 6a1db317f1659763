#include "server/operator/point_tiles.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/fake_station.hpp"

namespace headframe {
namespace {

struct Block {
  std::uint32_t keyframe = 0, points = 0;
  Eigen::Vector3f origin_m;
  std::vector<Eigen::Vector3d> p_m;  // in the session's frame
};

Block decoded(const std::string& bytes) {
  Block block;
  std::memcpy(&block.keyframe, bytes.data(), 4);
  std::memcpy(&block.points, bytes.data() + 4, 4);
  std::memcpy(block.origin_m.data(), bytes.data() + 8, 12);
  EXPECT_EQ(bytes.size(), 20 + 6UL * block.points);
  for (std::size_t i = 0; i < block.points; ++i) {
    std::array<std::int16_t, 3> p{};
    std::memcpy(p.data(), bytes.data() + 20 + 6 * i, 6);
    block.p_m.emplace_back(block.origin_m.cast<double>() + 0.005 * Eigen::Vector3d(p[0], p[1], p[2]));
  }
  return block;
}

// The fake: keyframes 1 and 2 of a session at x = 0 and 1 m see `points` points 1 m apart along x; 3 has no cloud.

TEST(PointTile, ACubeIsSentOnceAndTheFineLevelHoldsThePoints) {
  FakeStation station;
  PointTile tile(station, 1, 4);
  const Block first = decoded(**tile.block(0)), second = decoded(**tile.block(1));
  EXPECT_EQ(first.keyframe, 1U);
  EXPECT_EQ(first.points, 10U) << "the one that is no number is left out";
  EXPECT_EQ(second.keyframe, 2U);
  ASSERT_EQ(second.points, 1U) << "nine of its ten cubes were filled by the first";
  EXPECT_LT((second.p_m[0] - Eigen::Vector3d(10, 0, 1)).norm(), 0.005);
  EXPECT_FALSE(*tile.block(2));
}

TEST(PointTile, CoarserLevelsHaveFewerPoints) {
  FakeStation station;
  station.points = 40;
  std::vector<std::size_t> counts(level_cube_m.size());
  for (std::size_t level = 0; level < counts.size(); ++level)
    counts[level] = decoded(**PointTile(station, 1, level).block(0)).points;
  EXPECT_EQ(counts[0], 20U) << "2 m cubes, points 1 m apart";
  EXPECT_EQ(counts[1], 40U);
  EXPECT_TRUE(std::is_sorted(counts.begin(), counts.end()));
}

TEST(PointTile, BlocksAreMadeOnceAndLateCloudsComeAtTheEnd) {
  FakeStation station;
  station.withheld = 1;
  PointTile tile(station, 1, 4);
  EXPECT_EQ(decoded(**tile.block(0)).keyframe, 2U);
  EXPECT_FALSE(*tile.block(1));
  const std::string before = **tile.block(0);
  station.withheld = 0;
  EXPECT_EQ(decoded(**tile.block(1)).keyframe, 1U);
  EXPECT_EQ(**tile.block(0), before);
  const int reads = station.clouds_read;
  EXPECT_EQ(**tile.block(0), before);
  EXPECT_EQ(station.clouds_read, reads);
}

TEST(PointTiles, TheOldestGoWhenTheyAreTooMany) {
  FakeStation station;
  PointTiles tiles(station, 1);  // byte: only the newest fits
  const auto first = tiles.tile(1, 4, 100);
  ASSERT_TRUE(*first->block(0));
  EXPECT_EQ(tiles.tile(1, 4, 100), first);
  const auto second = tiles.tile(2, 4, 100);
  ASSERT_TRUE(*second->block(0));
  EXPECT_NE(tiles.tile(1, 4, 100), first);
}

TEST(PointTiles, ASessionThatHasBecomeShorterIsMadeAnew) {
  FakeStation station;
  PointTiles tiles(station);
  const auto tile = tiles.tile(1, 4, 3);
  ASSERT_TRUE(*tile->block(1));
  EXPECT_EQ(tiles.tile(1, 4, 2), tile) << "the second keyframe is still its";
  EXPECT_NE(tiles.tile(1, 4, 1), tile);
}

TEST(PointStream, EndsWhenTheBudgetIsSpent) {
  FakeStation station;
  const auto tile = std::make_shared<PointTile>(station, 1, 4);
  PointStream one(tile, 0, 10), all(tile, 0, 11), rest(tile, 1, 1000);
  EXPECT_TRUE(*one.next());
  EXPECT_FALSE(*one.next());
  EXPECT_TRUE(*all.next());
  EXPECT_TRUE(*all.next());
  EXPECT_FALSE(*all.next());
  EXPECT_EQ(decoded(**rest.next()).keyframe, 2U);
}

}  // namespace
}  // namespace headframe
