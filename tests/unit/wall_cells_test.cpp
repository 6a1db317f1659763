#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/place/wall_field.hpp"

namespace headframe {
namespace {

constexpr int columns = 70, rows = 50, rim = 14;

std::size_t cell(int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
}

/// Filled at random but for a rim.
CellWorth random_worth(std::mt19937& random) {
  std::uniform_int_distribution<int> worth(-3, 1);
  CellWorth out(columns * rows + worth_padding);
  for (int y = rim; y < rows - rim; ++y)
    for (int x = rim; x < columns - rim; ++x) out[cell(x, y)] = static_cast<std::int8_t>(worth(random));
  return out;
}

/// More than one block of points, some of them beyond the grid.
std::vector<Eigen::Vector2f> random_points(std::mt19937& random) {
  std::uniform_real_distribution<float> x(-10, columns + 10), y(-10, rows + 10);
  std::vector<Eigen::Vector2f> out(3 * cells_at_once + 5);
  for (auto& p : out) p = {x(random), y(random)};
  return out;
}

OnGrid as_it_is() { return {Eigen::Matrix2f::Identity(), {0, 0}, {columns, rows}, columns}; }

/// One cell after the other.
std::vector<std::int32_t> slow_windows(const std::vector<Eigen::Vector2f>& points, std::size_t every,
                                       const CellWorth& worth, CellWindow window) {
  const auto side = static_cast<int>(window.side());
  std::vector<std::int32_t> out;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      std::int32_t sum = 0;
      for (std::size_t i = 0; i < points.size(); i += every) {
        const int x = static_cast<int>(std::floor(points[i].x())) - window.reach + column * window.stride,
                  y = static_cast<int>(std::floor(points[i].y())) - window.reach + row * window.stride;
        if (x >= 0 && y >= 0 && x < columns && y < rows) sum += worth[cell(x, y)];
      }
      out.push_back(sum);
    }
  return out;
}

TEST(WallCells, AllShiftsOfAWindowAreSummedAsOneByOne) {
  std::mt19937 random(5);
  for (const CellWindow window : {CellWindow{6, 2}, CellWindow{2, 1}, CellWindow{0, 1}})
    for (const std::size_t every : {1U, 3U}) {
      const CellWorth worth = random_worth(random);
      const auto points = random_points(random);
      std::vector<std::int32_t> scores(window.side() * window.side());
      add_windows(points, every, as_it_is(), worth, window, scores);
      EXPECT_EQ(scores, slow_windows(points, every, worth, window)) << window.reach << " every " << every;
    }
}

TEST(WallCells, SumsOfManyEqualCellsAreNotCutOff) {
  CellWorth worth(columns * rows + worth_padding, -3);
  const std::vector<Eigen::Vector2f> points(100000, Eigen::Vector2f(30, 25));
  std::vector<std::int32_t> scores(49);
  add_windows(points, 1, as_it_is(), worth, {6, 2}, scores);
  for (const std::int32_t score : scores) EXPECT_EQ(score, -300000);
}

TEST(WallCells, PointsBeyondTheMarginGetTheCellOutside) {
  const std::vector<Eigen::Vector2f> points{{5, 5},           {4.999F, 5},   {5, 4.999F}, {columns - 5.001F, 5},
                                            {columns - 5, 5}, {5, rows - 5}, {-1e30F, 5}, {std::nanf(""), 5}};
  CellIndices cells;
  ASSERT_EQ(cells_under(points, as_it_is(), 5, -7, cells), points.size());
  const std::vector<std::int32_t> found(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(points.size()));
  EXPECT_EQ(found, (std::vector<std::int32_t>{5 * columns + 5, -7, -7, 5 * columns + columns - 6, -7, -7, -7, -7}));
}

TEST(WallField, CountsAsOneWallAndOneFreeCellAfterTheOther) {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> place(0, 40);
  const auto draw = [&] {
    WallMap out{{}, {}, 0.5F};
    for (int i = 0; i < 400; ++i)
      (i % 2 == 0 ? out.walls : out.free)
          .emplace_back(0.5F * static_cast<float>(place(random)), 0.5F * static_cast<float>(place(random)));
    return out;
  };
  const WallMap a = draw(), b = draw();
  const WallMatch placement{0.3, {2.13, -1.72}, 0};
  // What the field promises: a wall meets within 3x3 cells; a wall on free ground, or free ground on a wall,
  // contradicts.
  const auto nearest = [&](const std::vector<Eigen::Vector2f>& of, const Eigen::Vector2f& p) {
    const auto same = [&](const Eigen::Vector2f& q) { return ((q - p).array().abs() < 0.25F).all(); };
    return std::any_of(of.begin(), of.end(), same);
  };
  const Eigen::Rotation2Df turn(0.3F);
  WallFit expected;
  for (const auto& p : b.walls) {
    const Eigen::Vector2f here = turn * p + placement.shift_m.cast<float>();
    bool met = false;
    for (const float x : {-0.5F, 0.0F, 0.5F})
      for (const float y : {-0.5F, 0.0F, 0.5F}) met |= nearest(a.walls, here + Eigen::Vector2f(x, y));
    expected.met += met;
    expected.contradicted += !met && nearest(a.free, here);
    if (met) expected.middle += p.cast<double>();
  }
  for (const auto& p : b.free) expected.contradicted += nearest(a.walls, turn * p + placement.shift_m.cast<float>());
  ASSERT_GT(expected.met, 20);
  ASSERT_GT(expected.contradicted, 20);

  const WallField field(a);
  const WallFit fit = field.fit(b, placement);
  EXPECT_EQ(fit.met, expected.met);
  EXPECT_EQ(fit.contradicted, expected.contradicted);
  EXPECT_NEAR((fit.middle - expected.middle / expected.met).norm(), 0, 1e-9);
  EXPECT_EQ(field.score(b, placement), fit.score());
  EXPECT_EQ(WallField(WallMap{{}, {}, 0.5F}).score(b, placement), 0);
}

}  // namespace
}  // namespace headframe
