#include <gtest/gtest.h>

#include <complex>
#include <numbers>
#include <random>
#include <tuple>

#include "common/descriptor/wall_profile.hpp"
#include "server/place/descriptor_index.hpp"
#include "server/place/fft2.hpp"
#include "server/place/hypotheses.hpp"
#include "server/place/spectrum.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
constexpr double degree = std::numbers::pi / 180;

TEST(WallProfile, CodesKeepRangesWithinTwoPercent) {
  for (int i = 0; i < 88; ++i) {
    const float r = 0.3F * std::pow(1.07F, static_cast<float>(i));
    EXPECT_NEAR(decode_wall_range_m(encode_wall_range(r)), r, 0.013 * r);
  }
  EXPECT_EQ(encode_wall_range(0.29F), 0);
  EXPECT_EQ(encode_wall_range(std::nanf("")), 0);
  EXPECT_EQ(encode_wall_range(1e9F), encode_wall_range(120));
  EXPECT_EQ(decode_wall_range_m(0), 0);
}

TEST(WallProfile, TakesTheBandAroundTheHorizonOnly) {
  const double slope = std::tan(4.5 * degree);
  const auto seen = [](float z) { return wall_profile({{10, 0.1F, z}}).code[0] != 0; };
  EXPECT_TRUE(seen(static_cast<float>(10 * slope * 0.98)));
  EXPECT_FALSE(seen(static_cast<float>(10 * slope * 1.02)));
}

TEST(WallProfile, SectorsCountFromXTowardsY) {
  const WallProfile profile = wall_profile({{0.01F, 5, 0}, {-5, -0.01F, 0}});
  for (std::size_t i = 0; i < WallProfile::sectors; ++i) EXPECT_EQ(profile.code[i] != 0, i == 44 || i == 90) << i;
}

TEST(DescriptorIndex, FlannFindsWhatTheExactIndexFinds) {
  std::mt19937 rng(1);
  std::normal_distribution<float> n;
  const auto exact = make_exact_index(20), flann = make_flann_index(20);
  EXPECT_TRUE(exact->nearest(std::vector<float>(20), 3).empty());
  EXPECT_TRUE(flann->nearest(std::vector<float>(20), 3).empty());
  std::vector<float> q(20);
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    for (std::size_t k = 0; k < q.size(); ++k)
      q[k] = n(rng) * (k < 4 ? 5.0F : 0.5F);  // few strong directions, as real ones
    exact->add({1, i}, q);
    flann->add({1, i}, q);
  }
  int agree = 0;
  for (int i = 0; i < 100; ++i) {
    for (std::size_t k = 0; k < q.size(); ++k) q[k] = n(rng) * (k < 4 ? 5.0F : 0.5F);
    agree += exact->nearest(q, 1)[0].keyframe == flann->nearest(q, 1)[0].keyframe;
  }
  EXPECT_GE(agree, 95);
  EXPECT_EQ(exact->nearest(q, 5000).size(), 2000U);
}

/// Distances by the book, all sorted: what an exact index has to say.
std::vector<PlaceNeighbour> sorted_all(const std::vector<std::vector<float>>& rows, const std::vector<float>& q) {
  std::vector<PlaceNeighbour> out;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    float sum = 0;
    for (std::size_t d = 0; d < q.size(); ++d) sum += (rows[i][d] - q[d]) * (rows[i][d] - q[d]);
    out.push_back({{1, i}, sum});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& n, const auto& m) { return n.squared_distance < m.squared_distance; });
  return out;
}

TEST(DescriptorIndex, ExactIndexIsExactForAnySizeAndAnswersManyAsOne) {
  std::mt19937 rng(3);
  std::uniform_int_distribution<int> coarse(-3, 3);  // so that many lie equally far
  std::normal_distribution<float> fine;
  for (const std::size_t length : {1U, 7U, 64U})
    for (const std::size_t count : {1U, 15U, 16U, 17U, 500U}) {
      const float far = count == 17 ? 1000 : 0;  // long vectors near each other: lengths say little of distances
      const auto draw = [&](bool rough) {
        std::vector<float> q(length);
        for (float& v : q) v = far + (rough ? static_cast<float>(coarse(rng)) : fine(rng));
        return q;
      };
      const auto index = make_exact_index(length);
      std::vector<std::vector<float>> rows, questions;
      for (std::size_t i = 0; i < count; ++i) {
        std::vector<float>& row = rows.emplace_back(draw(i % 2 == 0));
        if (count == 500) std::fill(row.begin() + static_cast<std::ptrdiff_t>(length / 2), row.end(), 0.0F);
        index->add({1, i}, row);
      }
      for (int i = 0; i < 101; ++i) questions.push_back(draw(i % 2 == 0));
      const std::vector<std::span<const float>> qs(questions.begin(), questions.end());
      for (const std::size_t k : {0U, 1U, 5U, 20U, 1000U}) {
        const auto answers = index->nearest_of_each(qs, k, 2);
        ASSERT_EQ(answers.size(), questions.size());
        for (std::size_t i = 0; i < answers.size(); ++i) {
          const auto truth = sorted_all(rows, questions[i]);
          ASSERT_EQ(answers[i].size(), std::min(k, count));
          for (std::size_t n = 0; n < answers[i].size(); ++n) {
            EXPECT_EQ(answers[i][n].keyframe, truth[n].keyframe) << length << " " << count << " " << k;
            EXPECT_EQ(answers[i][n].squared_distance, truth[n].squared_distance);
          }
          const auto alone = index->nearest(questions[i], k);
          ASSERT_EQ(alone.size(), answers[i].size());
          for (std::size_t n = 0; n < alone.size(); ++n) EXPECT_EQ(alone[n].keyframe, truth[n].keyframe);
        }
      }
    }
}

TEST(DescriptorMatches, FiveNearestOfEachWithAPlaceVector) {
  std::vector<Keyframe> a(8), b(3);
  for (std::size_t i = 0; i < a.size(); ++i) a[i].descriptor.q = {static_cast<float>(i)};
  a[0].descriptor.q = {};      // none
  a[2].descriptor.q = {1, 1};  // of another length
  b[0].descriptor.q = {4.25F};
  b[2].descriptor.q = {1, 1};
  const auto matches = match_descriptors(a, b, 2);
  std::vector<std::size_t> of_a;
  for (const MatchedPair& m : matches) {
    EXPECT_EQ(m.b, 0U);
    of_a.push_back(m.a);
  }
  EXPECT_EQ(of_a, (std::vector<std::size_t>{4, 5, 3, 6, 7}));
  EXPECT_TRUE(match_descriptors({}, b, 1).empty());
  EXPECT_TRUE(match_descriptors(a, {}, 1).empty());
}

TEST(SessionWalls, LevelsAboveEachOtherAreDrawnApart) {
  std::vector<Keyframe> spiral(80);
  for (std::size_t i = 0; i < spiral.size(); ++i) {
    const double angle = 0.2 * static_cast<double>(i);  // a turn takes 31 keyframes and 9.4 m of depth
    spiral[i].T_local_sensor.translation() =
        Eigen::Vector3d(15 * std::cos(angle), 15 * std::sin(angle), -0.3 * static_cast<double>(i));
  }
  const auto levels = cut_levels(spiral);
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels[0].begin, 0U);
  EXPECT_EQ(levels[1].begin, levels[0].end);
  EXPECT_EQ(levels.back().end, spiral.size());
  for (auto& k : spiral) k.T_local_sensor.translation().z() = 0;
  EXPECT_EQ(cut_levels(spiral).size(), 1U);
  EXPECT_TRUE(cut_levels({}).empty());
}

TEST(Fft2, IsTheSlowTransform) {
  for (const std::size_t n : {16U, 32U, 48U, 96U}) {
    std::mt19937 rng(1);
    ComplexGrid grid(n * n);
    for (auto* values : {&grid.re, &grid.im})
      for (float& v : *values) v = static_cast<float>(rng() % 100) / 50 - 1;
    const ComplexGrid before = grid;
    Fft2 fft(n);
    fft.forward(grid);
    for (std::size_t k = 0; k < n * n; k += 37) {
      std::complex<double> sum = 0;
      for (std::size_t i = 0; i < n * n; ++i) {
        const std::size_t turns = (k / n) * (i / n) + (k % n) * (i % n);
        const double angle = -2 * std::numbers::pi * static_cast<double>(turns) / static_cast<double>(n);
        sum += std::complex<double>(before.re[i], before.im[i]) * std::polar(1.0, angle);
      }
      EXPECT_NEAR(grid.re[k], sum.real(), 1e-3);
      EXPECT_NEAR(grid.im[k], sum.imag(), 1e-3);
    }
    fft.inverse(grid);
    for (std::size_t i = 0; i < n * n; ++i) EXPECT_NEAR(grid.re[i], before.re[i] * static_cast<float>(n * n), 1e-2);
  }
  EXPECT_EQ(Fft2::size_for(1), 16U);
  EXPECT_EQ(Fft2::size_for(33), 48U);
  EXPECT_EQ(Fft2::size_for(49), 64U);
  EXPECT_EQ(Fft2::size_for(128), 128U);
  EXPECT_EQ(Fft2::size_for(129), 192U);
  EXPECT_EQ(Fft2::size_for(193), 256U);
}

TEST(Spectrum, CorrelatesWithFourRotationsAsTheGridsDo) {
  constexpr std::size_t n = 48;
  std::mt19937 rng(1);
  ComplexGrid a(n * n), b(n * n);  // walls, and free ground
  for (auto* values : {&a.re, &a.im, &b.re, &b.im})
    for (float& v : *values) v = static_cast<float>(rng() % 100) / 50 - 1;
  Fft2 fft(n);
  const auto spectrum = [&](ComplexGrid grid) {
    fft.forward(grid);
    Spectrum out(n);
    take_apart(grid, n, out);
    return out;
  };
  const Spectrum of_a = spectrum(a), of_b = spectrum(b);
  Spectrum b_turned(n);
  turn(of_b, n, b_turned);
  ComplexGrid product(n * n);
  for (int quarters = 0; quarters < 4; ++quarters) {
    correlate(of_a, of_b, b_turned, quarters >= 2, product);
    fft.inverse(product);
    for (std::size_t shift = 0; shift < n * n; shift += 97) {
      double sum = 0;
      for (std::size_t i = 0; i < n * n; ++i) {
        std::size_t x = i % n, y = i / n;
        for (int turn = 0; turn < quarters; ++turn) std::tie(x, y) = std::pair((n - y) % n, x);
        const std::size_t at = (y + shift / n) % n * n + (x + shift % n) % n;
        sum += static_cast<double>(a.re[at]) * static_cast<double>(b.re[i]) +
               static_cast<double>(a.im[at]) * static_cast<double>(b.im[i]);
      }
      const float found = quarters % 2 == 0 ? product.re[shift] : product.im[shift];
      EXPECT_NEAR(found / static_cast<float>(n * n), sum, 1e-2) << quarters << ' ' << shift;
    }
  }
}

TEST(WallSearch, FindsAMapLaidOnItselfAtAnyTurn) {
  const BoxMine mine({BoxMine::drift(0, 0, 80, 0), BoxMine::drift(30, 0, 30, 40)});
  const auto a = drive(mine, {{0, 0}, {30, 0}, {30, 38}}, 0, 1);
  const WallMap map = draw_wall_map(a.keyframes, 0.5F);
  for (const double yaw : {0.1, 1.7, -2.98, -1.38}) {  // one in each quarter
    WallMap turned = map;
    for (auto* list : {&turned.walls, &turned.free})
      for (auto& p : *list) p = Eigen::Rotation2Df(static_cast<float>(-yaw)) * (p - Eigen::Vector2f(5, 9));
    const auto found = search_walls(map, WallField(map), turned, 1, {}, 1);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(wrap_rad(found[0].yaw_rad - yaw), 0, 2 * degree);
    EXPECT_LT((found[0].shift_m - Eigen::Vector2d(5, 9)).norm(), 2);
    const WallField field(map);
    const WallMatch coarse = field.refine(turned, found[0], WallField::Step::coarse),
                    fine = field.refine(turned, coarse, WallField::Step::fine);
    EXPECT_GE(field.score(turned, fine), field.score(turned, coarse));
    EXPECT_LT((fine.shift_m - Eigen::Vector2d(5, 9)).norm(), 1);
  }
}

TEST(WallSearch, FindsWithinAStepHoweverCoarseItsStepsAre) {
  const BoxMine mine({BoxMine::drift(0, 0, 80, 0), BoxMine::drift(30, 0, 30, 40)});
  const WallMap map = draw_wall_map(drive(mine, {{0, 0}, {30, 0}, {30, 38}}, 0, 1).keyframes, 0.5F);
  const WallField field(map);
  for (const WallSearchSteps& steps : {WallSearchSteps{3, 15, 50, 3}, WallSearchSteps{6, 3, 4, 3}}) {
    const auto found = search_walls(map, field, map, 1000, steps, 1);
    ASSERT_FALSE(found.empty());
    EXPECT_LE(found.size(), 4 * steps.quarter_turns * steps.peaks);
    EXPECT_NEAR(found[0].yaw_rad, 0, 90 * degree / static_cast<double>(steps.quarter_turns));
    EXPECT_LT(found[0].shift_m.norm(), 2 * steps.cell_m);
  }
}

}  // namespace
}  // namespace headframe
