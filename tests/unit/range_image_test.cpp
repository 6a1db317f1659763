#include "common/descriptor/range_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace headframe {
namespace {

constexpr double deg = std::numbers::pi / 180;

Eigen::Vector3f beam(double azimuth_deg, double elevation_deg, double range_m) {
  const double a = azimuth_deg * deg, e = elevation_deg * deg;
  return (range_m * Eigen::Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e))).cast<float>();
}

RangeImage drawn(const Points& points) {
  return range_image(points, {.rows = 4, .columns = 8, .top_deg = 20, .bottom_deg = -20});
}

TEST(RangeImage, TheHighestBeamIsRowZeroAndColumnsGoFromXTowardsY) {
  const RangeImage image = drawn({beam(1, 19, 3), beam(91, -19, 7), beam(-1, 5, 9)});
  EXPECT_NEAR(image.at(0, 0), 3, 1e-5);
  EXPECT_NEAR(image.at(3, 2), 7, 1e-5);
  EXPECT_NEAR(image.at(1, 7), 9, 1e-5);
  EXPECT_NEAR(seen_share(image), 3.0 / 32, 1e-9);
}

TEST(RangeImage, BeamsOutsideTheRowsAreLeftOut) {
  EXPECT_EQ(seen_share(drawn({beam(10, 20.1, 5), beam(10, -20.1, 5), Eigen::Vector3f::Zero()})), 0);
  EXPECT_GT(seen_share(drawn({beam(10, 19.9, 5)})), 0);
  EXPECT_GT(seen_share(drawn({beam(10, -19.9, 5)})), 0);
}

TEST(RangeImage, APixelHoldsTheGeometricMean) {
  EXPECT_NEAR(drawn({beam(10, 15, 2), beam(20, 15, 8)}).at(0, 0), 4, 1e-4);
}

TEST(RangeImage, HolesAreBridgedUpToTheirLimit) {
  RangeImage image = drawn({beam(10, 15, 2), beam(10, -5, 8), beam(190, 15, 5)});
  RangeImage wide = image;
  fill_small_holes(image, 0, 2);
  EXPECT_EQ(seen_share(image), 3.0 / 32) << "one hole of a row, two of a column, three of a circle";
  fill_small_holes(image, 1, 2);
  EXPECT_NEAR(image.at(1, 0), 4, 1e-4) << "half way in the logarithm";
  EXPECT_EQ(image.at(3, 0), 0) << "nothing lies below";
  fill_small_holes(wide, 0, 3);
  for (std::size_t c = 0; c < 8; ++c) EXPECT_GT(wide.at(0, c), 0) << "a row is a circle: " << c;
  EXPECT_NEAR(wide.at(0, 6), std::sqrt(10), 1e-4);
}

TEST(RangeImage, TurningTheScanTurnsTheColumns) {
  Points points, turned;
  for (int i = 0; i < 64; ++i) {
    points.push_back(beam(5.6 * i + 1, 18 - 0.5 * i, 2 + 0.3 * i));
    turned.push_back(beam(5.6 * i + 1 + 90, 18 - 0.5 * i, 2 + 0.3 * i));
  }
  const RangeImage a = drawn(points), b = drawn(turned);
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 8; ++c) EXPECT_NEAR(a.at(r, c), b.at(r, (c + 2) % 8), 1e-4);
}

TEST(RangeImage, PlanesAreLogarithmAndMask) {
  const RangeImage image = drawn({beam(10, 15, 5), beam(55, 15, 5 * std::exp(1.5)), beam(100, 15, 0.1)});
  const auto planes = log_range_and_mask(image);
  ASSERT_EQ(planes.size(), 64u);
  EXPECT_NEAR(planes[0], 0, 1e-5);
  EXPECT_NEAR(planes[1], 1, 1e-5);
  EXPECT_NEAR(planes[2], std::log(0.1) / 1.5, 1e-5) << "not nearer than 0.5 m";
  EXPECT_EQ(planes[3], 0);
  EXPECT_EQ(planes[32], 1);
  EXPECT_EQ(planes[35], 0);
}

}  // namespace
}  // namespace headframe
