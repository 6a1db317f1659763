// Which sessions have points in the first answer that a page asks for.
#include "server/operator/overview.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/fake_station.hpp"

namespace headframe {
namespace {

/// The lengths of the points of each session.
std::vector<std::uint32_t> points_of_overview(const Station& station, PointTiles& tiles, std::size_t most_clouds) {
  Overview overview(station, tiles, 4, 1000, 0, most_clouds);
  std::string body;
  while (const auto piece = overview.next().value()) body += *piece;
  std::vector<std::uint32_t> lengths;
  for (std::size_t at = 0; at + 4 <= body.size(); at += 4 + lengths.back()) {
    lengths.push_back(0);
    std::memcpy(&lengths.back(), body.data() + at, sizeof(std::uint32_t));
  }
  std::vector<std::uint32_t> points;  // after the snapshot, and each path
  for (std::size_t i = 2; i < lengths.size(); i += 2) points.push_back(lengths[i]);
  return points;
}

TEST(Overview, HasPointsOfAsManySessionsAsHaveFewClouds) {
  FakeStation station;  // of two clouds each; sessions 2 and 3 are connected
  const auto lengths = [&](std::size_t most_clouds) {
    PointTiles tiles(station);
    return points_of_overview(station, tiles, most_clouds);
  };
  const auto all = lengths(6);
  ASSERT_EQ(all.size(), 3U);
  for (const std::uint32_t bytes : all) EXPECT_GT(bytes, 0U);
  using Lengths = std::vector<std::uint32_t>;
  EXPECT_EQ(lengths(5), (Lengths{0, all[1], all[2]}));
  EXPECT_EQ(lengths(3), (Lengths{0, 0, all[2]}));
  station.rows[2].connected = false;
  EXPECT_EQ(lengths(2), (Lengths{0, all[1], 0}));
  EXPECT_EQ(lengths(1), (Lengths{0, 0, 0}));
}

TEST(Overview, HasThePointsThatAreInMemory) {
  FakeStation station;
  PointTiles tiles(station);
  ASSERT_TRUE(tiles.tile(1, 4, 100)->block(0));
  ASSERT_TRUE(tiles.tile(3, 0, 100)->block(0)) << "of another level";
  const auto points = points_of_overview(station, tiles, 0);
  EXPECT_GT(points[0], 0U);
  EXPECT_EQ(points[1] + points[2], 0U);
}

}  // namespace
}  // namespace headframe
