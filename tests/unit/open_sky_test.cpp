#include "common/descriptor/open_sky.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headframe {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// An image with all of its pixels seen but those above the horizon in the columns [begin, end) and opposite them.
RangeImage with_gap(std::size_t begin, std::size_t end, bool opposite) {
  RangeImage image;
  image.range_m.assign(image.spec.rows * image.spec.columns, 5);
  for (std::size_t c = begin; c < end; ++c)
    for (std::size_t r = 0; r < image.spec.rows / 2; ++r) {
      image.at(r, c) = 0;
      if (opposite) image.at(r, c + image.spec.columns / 2) = 0;
    }
  return image;
}

/// The ground 1.2 m below, and three towers.
Points yard(double yaw_rad) {
  Points out;
  const auto add = [&](double azimuth, double range, double z) {
    out.push_back(
        Eigen::Vector3d(range * std::cos(azimuth - yaw_rad), range * std::sin(azimuth - yaw_rad), z).cast<float>());
  };
  for (int deg = 0; deg < 360; ++deg) {
    for (int i = 0; i < 8; ++i) add(deg * degree, 6 + 1.5 * i, -1.2);
    const bool tower = deg < 30 || (deg > 100 && deg < 115) || (deg > 250 && deg < 275);
    for (int i = 0; tower && i < 20; ++i) add(deg * degree, 9 + deg / 40.0, -1 + 0.25 * i);
  }
  return out;
}

TEST(OpenSky, IsWhereNothingStandsAboveTheHorizonAheadAndBehind) {
  const auto share = [](double part) { return static_cast<std::size_t>(std::lround(part * 128)); };
  EXPECT_EQ(openness(with_gap(0, 0, true)), 0);
  EXPECT_EQ(openness(with_gap(10, 100, false)), 0) << "a lidar off level sees nothing on one side";
  EXPECT_EQ(openness(with_gap(0, share(0.0156), true)), 0);
  EXPECT_GT(openness(with_gap(0, share(0.0313), true)), 0);
  EXPECT_LT(openness(with_gap(0, share(0.0547), true)), 1);
  EXPECT_EQ(openness(with_gap(0, share(0.0625), true)), 1);
  EXPECT_EQ(openness(range_image(yard(0), {})), 1);
}

TEST(OpenSky, AddsNothingUndergroundAndTheHandcraftedFamiliesOutside) {
  Descriptor closed{{1, 0}, {3, 1, 2, 5}}, half = closed, open = closed;
  ASSERT_TRUE(add_open_sky(closed, yard(0), 0));
  ASSERT_TRUE(add_open_sky(half, yard(0), 0.5));
  ASSERT_TRUE(add_open_sky(open, yard(0), 1));
  ASSERT_EQ(closed.q.size(), 2 + open_sky_q_size);
  EXPECT_EQ(std::count(closed.q.begin() + 2, closed.q.end(), 0.0F), open_sky_q_size);
  EXPECT_EQ(closed.w, (std::vector<float>{3, 1, 2, 5}));
  ASSERT_EQ(open.q.size(), closed.q.size());
  EXPECT_EQ(open.q[0], 1);
  for (std::size_t i = 2; i < open.q.size(); ++i) EXPECT_FLOAT_EQ(2 * half.q[i], open.q[i]);
  EXPECT_GT(*std::max_element(open.q.begin() + 2, open.q.begin() + 42), 0.05) << "heights";
  EXPECT_GT(*std::max_element(open.q.begin() + 42, open.q.end()), 0.01) << "energies";
}

TEST(OpenSky, ATurnKeepsQAndShiftsW) {
  const double turn_rad = 77 * degree;
  Descriptor a{{}, std::vector<float>(64, 0)}, b = a;
  ASSERT_TRUE(add_open_sky(a, yard(0), 1));
  ASSERT_TRUE(add_open_sky(b, yard(turn_rad), 1));
  for (std::size_t i = 0; i < a.q.size(); ++i) EXPECT_NEAR(a.q[i], b.q[i], 0.05);
  const auto yaws = correlate_circular(a.w, b.w, 1);
  ASSERT_FALSE(yaws.empty());
  EXPECT_NEAR(yaws[0].yaw_rad, turn_rad, 4 * degree);
}

TEST(OpenSky, AScanThatTheHandcraftedFamiliesRefuseIsAnError) {
  Descriptor d{{1}, {1, 2}};
  EXPECT_FALSE(add_open_sky(d, Points(3, Eigen::Vector3f(1, 0, 0)), 1));
}

}  // namespace
}  // namespace headframe
