#include "common/cloud/cloud_codec.hpp"

#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>
#include <random>

#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

/// A drift 5 m wide: walls, floor and roof with 1 cm of roughness.
Points drift(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> along(-15, 15), side(-2.5F, 2.5F);
  std::normal_distribution<float> rough(0, 0.01F);
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const float x = along(random), s = side(random), d = (i % 2 == 0 ? 2.5F : -2.5F) + rough(random);
    points.push_back(i % 4 < 2 ? Eigen::Vector3f(x, d, s) : Eigen::Vector3f(x, s, d));
  }
  return points;
}

float nearest(const Points& points, const Eigen::Vector3f& p) {  // largest difference on one axis
  float best = 1e9F;
  for (const auto& q : points) best = std::min(best, (q - p).cwiseAbs().maxCoeff());
  return best;
}

std::string compressed(const std::string& content) {
  std::string out(ZSTD_compressBound(content.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), content.data(), content.size(), 1));
  return out;
}

std::string header(std::uint64_t sweeps) {
  std::string s;
  put_varint(s, 1);
  put_float32(s, 0.01F);
  put_varint(s, sweeps);
  return s;
}

TEST(CloudCodec, EveryPointComesBackWithinHalfACell) {
  KeyframeCloud cloud;
  cloud.sweeps.push_back({{1.234F, -5.678F, 0.5F}, drift(2000, 1)});
  cloud.sweeps.push_back({{3, 3, 3}, {}});
  cloud.sweeps.push_back({Eigen::Vector3f::Zero(), {{-100.004F, 0, 0}, {120.3333F, -7, 2}, {120.3333F, -7, 2}}});
  const auto bytes = encode_cloud(cloud);
  ASSERT_TRUE(bytes);
  const auto back = decode_cloud(*bytes);
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->sweeps.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const Sweep &a = cloud.sweeps[i], &b = back->sweeps[i];
    EXPECT_LE((a.origin - b.origin).cwiseAbs().maxCoeff(), 0.005F + 1e-5F);
    ASSERT_EQ(a.points.size(), b.points.size());
    for (const auto& p : a.points) EXPECT_LE(nearest(b.points, p), 0.005F + 1e-5F);
    for (const auto& p : b.points) EXPECT_LE(nearest(a.points, p), 0.005F + 1e-5F);
  }
  EXPECT_EQ(*encode_cloud(*back), *bytes) << "points of the grid encode to the same bytes";
}

TEST(CloudCodec, AnEmptyCloudIsACloud) {
  const auto back = decode_cloud(*encode_cloud({}));
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->sweeps.empty());
}

TEST(CloudCodec, DenseCloudsTakeUnderTwoBytesAPoint) {
  KeyframeCloud cloud;
  cloud.sweeps.push_back({Eigen::Vector3f::Zero(), drift(60'000, 2)});
  const auto bytes = encode_cloud(cloud);
  ASSERT_TRUE(bytes);
  const double each = static_cast<double>(bytes->size()) / 60'000;
  RecordProperty("bytes_per_point", std::to_string(each));
  EXPECT_LT(each, 2.0);
}

TEST(CloudCodec, CoordinatesOutOfTheGridAreRefused) {
  const auto encode = [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return encode_cloud({{{Eigen::Vector3f::Zero(), {a, b}}}}, 1.0F).has_value();
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(encode({0, 0, 0}, {2097151, 0, 0}));
  EXPECT_FALSE(encode({0, 0, 0}, {2097152, 0, 0}));
  EXPECT_FALSE(encode({0, 0, 0}, {0, nan, 0}));
  EXPECT_FALSE(encode_cloud({{{{nan, 0, 0}, {}}}}));
  EXPECT_FALSE(encode_cloud({}, 0));
  KeyframeCloud many;
  many.sweeps.resize(limits::cloud_sweeps);
  EXPECT_TRUE(encode_cloud(many));
  many.sweeps.emplace_back();
  EXPECT_FALSE(encode_cloud(many));
}

TEST(CloudCodec, NoCutAndNoFlippedBitIsTakenForACloud) {
  const auto bytes = encode_cloud({{{Eigen::Vector3f::Zero(), drift(50, 3)}}});
  ASSERT_TRUE(bytes);
  for (std::size_t n = 0; n < bytes->size(); ++n) EXPECT_FALSE(decode_cloud(bytes->substr(0, n))) << n;
  EXPECT_FALSE(decode_cloud(*bytes + "x"));
  EXPECT_FALSE(decode_cloud(*bytes + *bytes));
  const auto whole = decode_cloud(*bytes);
  for (std::size_t bit = 0; bit < bytes->size() * 8; ++bit) {
    std::string flipped = *bytes;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    // Bits that zstd leaves unused change nothing; any other change must be seen.
    const auto cloud = decode_cloud(flipped);
    EXPECT_TRUE(!cloud || *encode_cloud(*cloud) == *encode_cloud(*whole)) << bit;
  }
}

TEST(CloudCodec, LiesAboutSizesCostNothing) {
  std::string sweeps = header(limits::cloud_sweeps + 1);
  EXPECT_FALSE(decode_cloud(compressed(sweeps)));
  std::string count = header(1) + std::string(3, '\0');
  put_varint(count, 1'000'000'000'000ULL);
  EXPECT_FALSE(decode_cloud(compressed(count)));
  std::string trailing = header(0) + "x";
  EXPECT_FALSE(decode_cloud(compressed(trailing)));
  EXPECT_TRUE(decode_cloud(compressed(header(0))));
  // A few KB that announce 64 MB of zeros.
  const auto bomb = decode_cloud(compressed(std::string(64 << 20, '\0')));
  ASSERT_FALSE(bomb);
  EXPECT_NE(bomb.error().message.find("announced"), std::string::npos) << bomb.error().message;
}

TEST(CloudCodec, MortonCodesMayNotRunOver) {
  const auto with_step = [](std::uint64_t step) {
    std::string s = header(1) + std::string(3, '\0');
    put_varint(s, 2);
    s += std::string(3, '\0');
    put_varint(s, (1ULL << 63) - 2);
    put_varint(s, step);
    return compressed(s);
  };
  EXPECT_TRUE(decode_cloud(with_step(1)));
  EXPECT_FALSE(decode_cloud(with_step(2)));
}

}  // namespace
}  // namespace headframe
