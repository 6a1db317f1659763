#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/cloud/cloud_codec.hpp"
#include "common/cloud/intensity_code.hpp"
#include "common/cloud/intensity_scale.hpp"
#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"
#include "tests/support/zstd_frames.hpp"

namespace headframe {
namespace {

using test::compressed;
using test::content_of;

/// A wall 20 m long that grows brighter to one end, with noise.
Sweep painted_wall(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> along(-10, 10), up(-2, 2);
  std::normal_distribution<float> noise(0, 8);
  Sweep sweep;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p(along(random), 2.5F, up(random));
    sweep.points.push_back(p);
    sweep.intensity.push_back(static_cast<std::uint8_t>(std::clamp(90 + 8 * p.x() + noise(random), 0.0F, 255.0F)));
  }
  return sweep;
}

KeyframeCloud unpainted(KeyframeCloud cloud) {
  for (Sweep& sweep : cloud.sweeps) sweep.intensity.clear();
  return cloud;
}

using Row = std::array<int, 4>;  // x, y, z in cells of 1 m, and what is read of the intensity

std::vector<Row> rows_of(const Sweep& sweep, bool as_written) {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Eigen::Vector3i c = sweep.points[i].array().round().cast<int>();
    const std::uint8_t value = sweep.intensity.at(i);
    rows.push_back({c.x(), c.y(), c.z(), as_written ? intensity_of_level(intensity_level(value)) : value});
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

TEST(CloudIntensity, EveryPointKeepsItsOwn) {
  KeyframeCloud cloud{{painted_wall(500, 1), Sweep{{1, 2, 3}, {}}, painted_wall(3, 2), painted_wall(40, 3)}};
  cloud.sweeps[2].intensity.clear();  // a sweep without, among others
  cloud.sweeps.push_back({{0, 0, 0}, Points(4, {7, 7, 7}), {200, 10, 10, 0}});
  const auto bytes = encode_cloud(cloud, 1.0F);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(content_of(*bytes).at(0), 3);
  const auto back = decode_cloud(*bytes);
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->sweeps.size(), 5U);
  EXPECT_TRUE(back->sweeps[1].intensity.empty());
  EXPECT_TRUE(back->sweeps[2].intensity.empty());
  EXPECT_EQ(back->sweeps[2].points.size(), 3U);
  for (const std::size_t i : {0U, 3U, 4U}) EXPECT_EQ(rows_of(back->sweeps[i], false), rows_of(cloud.sweeps[i], true));
  EXPECT_EQ(*encode_cloud(*back, 1.0F), *bytes) << "levels encode to the same bytes";
}

TEST(CloudIntensity, LevelsAreFineWhereReturnsAreFaint) {
  for (int value = 0; value < 256; ++value) {
    const auto level = intensity_level(static_cast<std::uint8_t>(value));
    EXPECT_LT(level, intensity_levels);
    const int read = intensity_of_level(level);
    EXPECT_LE(std::abs(read - value), 8) << value;
    if (value < 64) {
      EXPECT_LE(std::abs(read - value), 4) << value;
    }
    EXPECT_EQ(intensity_level(static_cast<std::uint8_t>(read)), level) << value;
  }
  EXPECT_EQ(intensity_of_level(0), 0);
  EXPECT_EQ(intensity_of_level(31), 255);
}

TEST(CloudIntensity, AReaderWithoutGetsTheCloudAsItEverWas) {
  const KeyframeCloud cloud{{painted_wall(800, 4), painted_wall(300, 5)}};
  const auto bytes = encode_cloud(cloud), plain = encode_cloud(unpainted(cloud));
  ASSERT_TRUE(bytes && plain);
  EXPECT_EQ(content_of(*plain).at(0), 2);
  EXPECT_EQ(without_intensity(*bytes).value(), *plain);
  EXPECT_EQ(without_intensity(*plain).value(), *plain);
  const auto points = decode_points(*bytes);
  ASSERT_TRUE(points);
  EXPECT_EQ(*encode_cloud(*points), *plain);
  for (const Sweep& sweep : points->sweeps) EXPECT_TRUE(sweep.intensity.empty());
  EXPECT_EQ(without_intensity("a cloud").error().code, ErrorCode::bad_input);
  EXPECT_EQ(without_intensity(compressed("\x03\x7f")).error().code, ErrorCode::bad_input);
}

TEST(CloudIntensity, OneTooManyOrTooFewIsNoCloud) {
  KeyframeCloud cloud{{painted_wall(10, 6)}};
  for (const std::size_t n : {1U, 9U, 11U}) {
    cloud.sweeps[0].intensity.resize(n);
    EXPECT_EQ(encode_cloud(cloud).error().code, ErrorCode::invalid_argument) << n;
  }
  cloud.sweeps[0].intensity.resize(10);
  EXPECT_TRUE(encode_cloud(cloud));
  EXPECT_FALSE(encode_cloud({{Sweep{{0, 0, 0}, {}, {1}}}})) << "of no point";
}

TEST(CloudIntensity, AreLeftOutOfTheLargestClouds) {
  KeyframeCloud cloud{{painted_wall(262'144, 7)}};
  const auto most = encode_cloud(cloud, 0.1F);
  ASSERT_TRUE(most);
  EXPECT_EQ(content_of(*most).at(0), 3);
  EXPECT_EQ(decode_cloud(*most)->sweeps[0].intensity.size(), 262'144U);
  cloud.sweeps.push_back(painted_wall(1, 8));
  const auto more = encode_cloud(cloud, 0.1F);
  ASSERT_TRUE(more);
  EXPECT_EQ(content_of(*more).at(0), 1);
  EXPECT_EQ(*more, *encode_cloud(unpainted(cloud), 0.1F));

  std::string announced;
  put_varint(announced, 3);
  put_varint(announced, content_of(*more).size());
  EXPECT_FALSE(decode_cloud(compressed(announced + content_of(*more) + std::string(100'000, '\0'))))
      << "nor are they read";
}

TEST(CloudIntensity, GoWithCloudsOfTheFirstForm) {
  const KeyframeCloud cloud{{Sweep{{0, 0, 0}, Points(40, {1, 2, 3}), Intensities(40, 99)}}};
  const auto bytes = encode_cloud(cloud);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(content_of(*bytes).at(2), 1) << "one place 40 times";
  const auto back = decode_cloud(*bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->sweeps[0].intensity, Intensities(40, intensity_of_level(intensity_level(99))));
}

TEST(CloudIntensity, AnyChangeGivesACloudOfItsSizeOrBadInput) {
  const std::string content = content_of(*encode_cloud({{painted_wall(200, 9), painted_wall(50, 10)}}));
  std::mt19937 random(11);
  int read = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string changed = content;
    for (unsigned n = random() % 4 + 1; n > 0; --n) changed[random() % changed.size()] = static_cast<char>(random());
    if (random() % 4 == 0) changed.resize(random() % changed.size());
    const auto cloud = decode_cloud(compressed(changed));
    if (!cloud) {
      EXPECT_EQ(cloud.error().code, ErrorCode::bad_input);
      continue;
    }
    ++read;
    for (const Sweep& sweep : cloud->sweeps)
      EXPECT_TRUE(sweep.intensity.empty() || sweep.intensity.size() == sweep.points.size());
  }
  EXPECT_GT(read, 0) << "some changes only move points, or paint them";
  for (std::size_t n = 0; n < content.size(); ++n) EXPECT_FALSE(decode_cloud(compressed(content.substr(0, n)))) << n;
  EXPECT_FALSE(decode_cloud(compressed(content + '\0'))) << "a byte too many";
}

TEST(CloudIntensity, LiesAboutTheCloudInFrontAreSeen) {
  const std::string content = content_of(*encode_cloud({{painted_wall(20, 12)}}));
  std::string nested;
  put_varint(nested, 3);
  put_varint(nested, content.size());
  EXPECT_FALSE(decode_cloud(compressed(nested + content))) << "a cloud with intensities in front of intensities";
  std::string far;
  put_varint(far, 3);
  put_varint(far, ~0ULL);
  EXPECT_FALSE(decode_cloud(compressed(far + content.substr(2))));
  EXPECT_FALSE(decode_points(compressed(far + content.substr(2))));
}

TEST(CloudIntensity, TakesLessThanAThirdOfTheCloud) {
  const KeyframeCloud cloud{{painted_wall(30'000, 13)}};
  const double plain = static_cast<double>(encode_cloud(unpainted(cloud))->size());
  const double share = static_cast<double>(encode_cloud(cloud)->size()) / plain - 1;
  RecordProperty("share_of_the_cloud", std::to_string(share));
  EXPECT_LT(share, 0.35);
}

TEST(PointCloud, FiltersKeepIntensitiesWithTheirPoints) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Points points{{1, 0, 0}, {nan, 0, 0}, {0, 0, 0}, {1.05F, 0, 0}, {9, 9, 9}, {1e9F, 0, 0}};
  const Intensities intensity{10, 20, 30, 13, 50, 60};
  const Returns finite = finite_points(points, intensity, 0.5F);
  EXPECT_EQ(finite.points, finite_points(points, 0.5F));
  EXPECT_EQ(finite.intensity, (Intensities{10, 13, 50, 60}));
  const Returns thinned = voxel_grid(finite.points, finite.intensity, 0.1F);
  EXPECT_EQ(thinned.points, voxel_grid(finite.points, 0.1F));
  EXPECT_EQ(thinned.intensity, (Intensities{12, 50})) << "the mean, rounded; points out of reach are dropped";
  EXPECT_TRUE(finite_points(points, {}, 0.5F).intensity.empty());
  EXPECT_TRUE(voxel_grid(points, {}, 0.5F).intensity.empty());
}

TEST(IntensityScale, FindsOutWhatFullScaleIs) {
  EXPECT_EQ(IntensityScale().scaled({0, 0.5F, 1}), (Intensities{0, 128, 255}));
  EXPECT_EQ(IntensityScale().scaled({0, 0.5F, 100, 255}), (Intensities{0, 1, 100, 255}));
  EXPECT_EQ(IntensityScale().scaled({0, 65535.0F / 4, 65535, 1e9F}), (Intensities{0, 128, 255, 255}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(IntensityScale().scaled({nan, -3, 1, std::numeric_limits<float>::infinity()}), (Intensities{0, 0, 255, 0}));
  EXPECT_TRUE(IntensityScale().scaled({0, 0, nan}).empty()) << "a driver that fills the field";
  EXPECT_TRUE(IntensityScale().scaled({}).empty());
}

TEST(IntensityScale, KeepsTheScaleOfTheSession) {
  IntensityScale scale;
  EXPECT_EQ(scale.scaled({0.2F, 1}), (Intensities{51, 255}));
  EXPECT_EQ(scale.scaled({0.2F, 2}), (Intensities{0, 2}));
  EXPECT_EQ(scale.scaled({0.2F, 1}), (Intensities{0, 1})) << "a dark scan does not change it back";
  std::vector<float> raw(100, 100);
  raw[0] = 900;
  EXPECT_EQ(scale.scaled(raw)[0], 255) << "one in a hundred is clamped";
  EXPECT_EQ(scale.scaled(raw)[1], 100);
  raw[1] = 900;
  EXPECT_EQ(scale.scaled(raw)[2], 10) << "two in a hundred are another scale";
}

}  // namespace
}  // namespace headframe
