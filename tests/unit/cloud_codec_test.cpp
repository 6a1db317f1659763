#include "common/cloud/cloud_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"
#include "tests/support/zstd_frames.hpp"

namespace headframe {
namespace {

using test::compressed;
using test::content_of;

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

char form_of(const std::string& encoded) { return content_of(encoded).at(0); }

std::string header(std::uint64_t sweeps, std::uint64_t form = 1) {
  std::string s;
  put_varint(s, form);
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

TEST(CloudCodec, CloudsOfTheFirstFormAreStillRead) {
  std::string s = header(1);
  for (const int c : {100, -200, 0}) put_signed(s, c);
  put_varint(s, 3);
  for (const int c : {-5, 0, 7}) put_signed(s, c);
  for (const int step : {0, 1 + 2 + 8, 0}) put_varint(s, static_cast<std::uint64_t>(step));
  const auto cloud = decode_cloud(compressed(s));
  ASSERT_TRUE(cloud) << cloud.error().message;
  const Sweep& sweep = cloud->sweeps.at(0);
  EXPECT_LT((sweep.origin - Eigen::Vector3f(1, -2, 0)).norm(), 1e-6F);
  ASSERT_EQ(sweep.points.size(), 3U);
  EXPECT_LT((sweep.points[0] - Eigen::Vector3f(-0.05F, 0, 0.07F)).norm(), 1e-6F);
  EXPECT_LT((sweep.points[1] - Eigen::Vector3f(-0.02F, 0.01F, 0.07F)).norm(), 1e-6F);
  EXPECT_EQ(sweep.points[2], sweep.points[1]);
  EXPECT_EQ(form_of(*encode_cloud(*cloud)), 2) << "what is written now";
}

TEST(CloudCodec, AFormOfLaterVersionsIsRefusedByName) {
  const auto later = decode_cloud(compressed(header(0, 4)));
  ASSERT_FALSE(later);
  EXPECT_NE(later.error().message.find("form 4, only 1 to 3 are known"), std::string::npos) << later.error().message;
}

TEST(CloudCodec, CloudsThatWouldBeSlowToReadTakeTheFirstForm) {
  const Eigen::Vector3f point(1, 2, 3);
  KeyframeCloud same{{{Eigen::Vector3f::Zero(), Points(10'000, point)}}};
  const auto bytes = encode_cloud(same);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(form_of(*bytes), 1);
  EXPECT_EQ(decode_cloud(*bytes)->sweeps[0].points, same.sweeps[0].points);
  KeyframeCloud many{{{Eigen::Vector3f::Zero(), drift(262'144, 4)}}};
  EXPECT_EQ(form_of(*encode_cloud(many)), 2);
  many.sweeps[0].points.push_back(point);
  EXPECT_EQ(form_of(*encode_cloud(many)), 1);
}

TEST(CloudCodec, WhatIsWrittenIsReadHoweverFewBytesItTakes) {
  for (std::size_t n = 1; n < 200; ++n) {
    Points points(n, Eigen::Vector3f(1, 2, 3));
    for (std::size_t i = 0; i < n; i += 9) points[i].x() += static_cast<float>(i);
    const auto bytes = encode_cloud({{{Eigen::Vector3f::Zero(), points}}}, 1.0F);
    ASSERT_TRUE(bytes);
    const auto back = decode_cloud(*bytes);
    ASSERT_TRUE(back) << n << " points: " << back.error().message;
    EXPECT_EQ(point_count(*back), n);
  }
}

TEST(CloudCodec, EveryShapeComesBackExactly) {
  const auto on_grid = [](const std::vector<std::array<int, 3>>& cells) {
    KeyframeCloud cloud{{Sweep{}}};
    for (const auto& c : cells) cloud.sweeps[0].points.push_back(Eigen::Vector3i(c[0], c[1], c[2]).cast<float>());
    return cloud;
  };
  const int far = (1 << 21) - 1;
  for (const auto& cells :
       std::vector<std::vector<std::array<int, 3>>>{{{5, -6, 7}},
                                                    {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}},
                                                    {{0, 0, 0}, {far, far, far}},
                                                    {{0, 0, 0}, {far, 0, 0}, {far, 0, 0}},
                                                    {{0, 0, 0}, {31, 31, 31}, {0, 31, 0}, {32, 0, 0}, {33, 0, 0}}}) {
    const KeyframeCloud cloud = on_grid(cells);
    const auto bytes = encode_cloud(cloud, 1.0F);
    ASSERT_TRUE(bytes);
    EXPECT_EQ(form_of(*bytes), 2);
    auto back = decode_cloud(*bytes);
    ASSERT_TRUE(back) << back.error().message;
    auto sorted = [](Points points) {
      std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
        return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
      });
      return points;
    };
    EXPECT_EQ(sorted(back->sweeps[0].points), sorted(cloud.sweeps[0].points));
  }
}

TEST(CloudCodec, AnyChangeOfAnOctreesBytesGivesACloudOfItsSizeOrNone) {
  const auto encoded =
      encode_cloud({{{Eigen::Vector3f::Zero(), drift(300, 3)}, {Eigen::Vector3f::Ones(), drift(9, 4)}}});
  ASSERT_TRUE(encoded);
  const std::string content = content_of(*encoded);
  std::mt19937 random(5);
  int read = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string changed = content;
    for (unsigned n = random() % 4 + 1; n > 0; --n) changed[random() % changed.size()] = static_cast<char>(random());
    if (random() % 4 == 0) changed.resize(random() % changed.size());
    const auto cloud = decode_cloud(compressed(changed));
    if (cloud) {
      EXPECT_LE(point_count(*cloud), 2 * changed.size());
    }
    read += cloud ? 1 : 0;
  }
  EXPECT_GT(read, 0) << "some changes only move points";
  EXPECT_FALSE(decode_cloud(compressed(content + '\0'))) << "a byte too many";
  EXPECT_FALSE(decode_cloud(compressed(content.substr(0, content.size() - 1))));
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
