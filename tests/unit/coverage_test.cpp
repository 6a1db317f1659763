// What was seen of a mine from above: the grid against a room whose walls are known, and the code of its tiles.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "common/descriptor/wall_profile.hpp"
#include "server/surroundings/coverage_grid.hpp"

namespace headframe {
namespace {

constexpr std::size_t plenty = 1000;

/// Distance from a place in a room of 2a x 2b around the origin to its wall, in this direction.
double to_wall_m(const Eigen::Vector2d& from, double azimuth_rad, double a, double b) {
  const double c = std::cos(azimuth_rad), s = std::sin(azimuth_rad);
  const double x = c > 0 ? (a - from.x()) / c : c < 0 ? (-a - from.x()) / c : 1e9;
  const double y = s > 0 ? (b - from.y()) / s : s < 0 ? (-b - from.y()) / s : 1e9;
  return std::min(x, y);
}

WallProfile room_walls(const Pose& T_room_sensor, double a, double b) {
  WallProfile walls;
  for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
    const double azimuth_rad = yaw_rad(T_room_sensor) + (static_cast<double>(i) + 0.5) * std::numbers::pi / 90;
    walls.code[i] =
        encode_wall_range(static_cast<float>(to_wall_m(T_room_sensor.translation().head<2>(), azimuth_rad, a, b)));
  }
  return walls;
}

CoverageCell cell_at(const CoverageGrid& grid, int x, int y) {
  const auto tile_of = [](int cell) { return cell >= 0 ? cell / 32 : -((31 - cell) / 32); };
  const auto tile = grid.tiles().find({tile_of(x), tile_of(y)});
  if (tile == grid.tiles().end()) return {};
  return tile->second.cells.at(static_cast<std::size_t>((y - 32 * tile_of(y)) * 32 + x - 32 * tile_of(x)));
}

TEST(Coverage, InARoomAllWithinIsFreeTheWallsAreWallsAndNothingIsSeenBehindThem) {
  CoverageGrid grid(plenty);
  const Pose T = pose_from_yaw(0.4, {2.3, -1.2, 1});
  const double a = 9.5, b = 6.5;  // walls in the middle of cells
  grid.see(7, T, 6000, room_walls(T, a, b));
  for (int x = -40; x < 40; ++x)
    for (int y = -40; y < 40; ++y) {
      const CoverageCell cell = cell_at(grid, x, y);
      const double cx = std::abs(x + 0.5), cy = std::abs(y + 0.5);
      if (cx < a - 1 && cy < b - 1) {
        EXPECT_EQ(cell.what, coverage_free) << x << ' ' << y;
      } else if (cx > a + 1 || cy > b + 1) {
        EXPECT_EQ(cell.what, 0) << x << ' ' << y;
      } else if ((cx == a && cy < b) || (cy == b && cx < a)) {
        EXPECT_TRUE(cell.what & coverage_wall) << x << ' ' << y;
      }
      EXPECT_EQ(cell.session, cell.what != 0 ? 7U : 0U);
      EXPECT_EQ(cell.last_seen, cell.what != 0 ? 10 : 0);
    }
}

TEST(Coverage, WhatIsFartherThanItsRangeIsLeftOutOnBothSidesOfIt) {
  WallProfile walls;
  walls.code[0] = encode_wall_range(29);
  walls.code[90] = encode_wall_range(32);  // behind
  CoverageGrid grid(plenty);
  grid.see(1, Pose::Identity(), 0, walls);
  bool wall_ahead = false;
  for (int x = 27; x < 31; ++x) wall_ahead = wall_ahead || (cell_at(grid, x, 0).what & coverage_wall) != 0;
  EXPECT_TRUE(wall_ahead);
  EXPECT_EQ(cell_at(grid, -30, -1).what, coverage_free);
  for (int x = -40; x < -31; ++x) EXPECT_EQ(cell_at(grid, x, -1).what, 0);
}

TEST(Coverage, TheOrderOfWhatIsSeenDoesNotMatter) {
  struct Seen {
    std::uint32_t session;
    Pose T;
    double stamp_s;
  };
  std::vector<Seen> all;
  all.reserve(20);
  for (int i = 0; i < 20; ++i)
    all.push_back(
        {1U + static_cast<std::uint32_t>(i) % 3, pose_from_yaw(i, {0.4 * i - 4, 0.1 * i, 0}), 250.0 * (i % 7)});
  const auto drawn = [&] {
    CoverageGrid grid(plenty);
    for (const Seen& s : all) {
      grid.see(s.session, s.T, s.stamp_s, room_walls(s.T, 12, 8));
      grid.walk(s.session, s.T.translation(), s.T.translation() + Eigen::Vector3d(3, 1, 0), s.stamp_s);
    }
    return grid;
  };
  const CoverageGrid first = drawn();
  std::shuffle(all.begin(), all.end(), std::mt19937(5));
  const CoverageGrid second = drawn();
  ASSERT_EQ(first.tiles().size(), second.tiles().size());
  for (const auto& [index, tile] : first.tiles()) EXPECT_EQ(encode_tile(tile), encode_tile(second.tiles().at(index)));
}

TEST(Coverage, SeenAgainInTheSameTimeNothingChangesAndLaterItDoes) {
  CoverageGrid grid(plenty);
  const WallProfile walls = room_walls(Pose::Identity(), 5, 5);
  grid.see(2, Pose::Identity(), 1200, walls);
  EXPECT_EQ(grid.take_changed().size(), 4U);
  grid.see(2, Pose::Identity(), 1799, walls);
  EXPECT_TRUE(grid.take_changed().empty());
  grid.see(2, Pose::Identity(), 1800, walls);
  EXPECT_EQ(grid.take_changed().size(), 4U);
}

TEST(Coverage, NoMoreTilesThanItMayHave) {
  CoverageGrid grid(3);
  for (int i = 0; i < 3; ++i) grid.walk(1, {32.0 * i + 1, 1, 0}, {32.0 * i + 2, 1, 0}, 0);
  EXPECT_EQ(grid.tiles().size(), 3U);
  EXPECT_FALSE(grid.full());
  grid.walk(1, {200, 1, 0}, {201, 1, 0}, 0);
  EXPECT_EQ(grid.tiles().size(), 3U);
  EXPECT_TRUE(grid.full());
}

CoverageTile drawn_tile(unsigned seed) {
  std::mt19937 random(seed);
  CoverageTile tile;
  for (CoverageCell& cell : tile.cells) {
    if (random() % 3 == 0) continue;
    cell = {static_cast<std::uint8_t>(1 + random() % 7), static_cast<std::int32_t>(random() % 5000) - 2500,
            static_cast<std::uint32_t>(random() % 9) * 477218588U};
    auto& seen = tile.seen_by.try_emplace(cell.session, cell.last_seen).first->second;
    seen = std::max(seen, cell.last_seen);
  }
  return tile;
}

TEST(CoverageTileCode, ATileComesBackAsItWas) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const CoverageTile tile = drawn_tile(seed);
    const auto back = decode_tile(encode_tile(tile));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->cells, tile.cells);
    EXPECT_EQ(back->seen_by, tile.seen_by);
  }
  EXPECT_EQ(encode_tile(CoverageTile{}), "") << "nobody has seen it";
  EXPECT_TRUE(decode_tile("")->seen_by.empty());
}

TEST(CoverageTileCode, WhateverBytesComeTheyAreATileOrAFault) {
  const std::string whole = encode_tile(drawn_tile(3));
  for (std::size_t cut = 1; cut < whole.size(); ++cut) EXPECT_FALSE(decode_tile(whole.substr(0, cut)));
  std::mt19937 random(1);
  std::size_t faults = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string changed = whole;
    for (int k = 0; k < 3; ++k) changed[random() % changed.size()] = static_cast<char>(random());
    faults += decode_tile(changed) ? 0U : 1U;
  }
  EXPECT_GT(faults, 500U);
}

TEST(CoverageTileCode, TimesBeyondAllClocksAreKeptWithinTheCode) {
  EXPECT_EQ(coverage_time(599.9), 0);
  EXPECT_EQ(coverage_time(600), 1);
  EXPECT_EQ(coverage_time(-0.1), -1);
  EXPECT_EQ(coverage_time(1e300), 2000000000);
  EXPECT_EQ(coverage_time(-1e300), -2000000000);
}

}  // namespace
}  // namespace headframe
