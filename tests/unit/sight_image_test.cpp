#include "server/verification/sight_image.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;

TEST(SightImage, HitThroughAndHidden) {
  const BoxMine room({{{-5, -5, -1}, {5, 5, 2}}});
  std::mt19937 rng(1);
  const SightImage image(room.scan(Pose::Identity(), rng, 0, 64, 360));
  const float tolerance = 0.35F + 0.03F * 5;
  EXPECT_EQ(image.look({5, 0, 0}, 30), Sight::hit);
  EXPECT_EQ(image.look({5 - 0.8F * tolerance, 0, 0}, 30), Sight::hit);
  EXPECT_EQ(image.look({5 - 1.6F * tolerance, 0, 0}, 30), Sight::through);
  EXPECT_EQ(image.look({5 - 1.6F * tolerance, 0, 0}, 30, 0.8F * tolerance), Sight::hit) << "with slack";
  EXPECT_EQ(image.look({5 - 1.6F * tolerance, 0, 0}, 30, 0.3F * tolerance), Sight::through);
  EXPECT_EQ(image.look({5 + 2 * tolerance, 0, 0}, 30), Sight::unknown) << "behind the wall";
  EXPECT_EQ(image.look({2, 0, 0}, 1.9F), Sight::unknown) << "out of reach";
  EXPECT_EQ(image.look({0.1F, 0, 3}, 30), Sight::unknown) << "above the field of view";
  EXPECT_EQ(SightImage(Points{}).look({1, 0, 0}, 30), Sight::unknown);
}

TEST(SightImage, ABlockIsSeenLikeItsPoints) {
  const BoxMine drift({BoxMine::drift(-20, 0, 20, 0)});
  std::mt19937 rng(1);
  const SightImage image(drift.scan(pose_from_yaw(0, {0, 0, 1}), rng, 0, 32, 512));
  std::uniform_real_distribution<float> along(-25, 25), across(-4, 4);
  std::array<int, 3> seen{};
  for (std::size_t count = 0; count <= SightBlock::most; ++count) {
    SightBlock block;
    block.count = count;
    Points points{Eigen::Vector3f::Zero(), {0, 0, 3}, {std::nanf(""), 0, 0}, {-5, 0, 0}, {-5, -0.0F, 0}, {1e9F, 0, 0}};
    while (points.size() < count) points.emplace_back(along(rng), across(rng), 0.5F * across(rng));
    for (std::size_t i = 0; i < count; ++i) {
      block.x[i] = points[i].x();
      block.y[i] = points[i].y();
      block.z[i] = points[i].z();
    }
    std::array<Sight, SightBlock::most> answers{};
    image.look(block, 20, answers);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(answers[i], image.look(points[i], 20)) << points[i].transpose();
      ++seen.at(static_cast<std::size_t>(answers[i]));
    }
  }
  for (const int of_each : seen) EXPECT_GT(of_each, 50);
}

/// A sweep in bins of 2 deg, read as the class describes it.
class PlainReading {
 public:
  explicit PlainReading(const Points& points) {
    for (const auto& p : points)
      if (p.norm() > 0.1F) bins_[bin_of(p)].push_back(std::floor(100 * p.norm()) / 100);
  }
  Sight look(const Eigen::Vector3f& point, float reach_m) const {
    const auto [row, column] = bin_of(point);
    const float range = point.norm(), tolerance = 0.35F + 0.03F * range;
    if (range > reach_m || range < 0.5F || !bins_.contains({row, column})) return Sight::unknown;
    float nearest = 1e9F, farthest = 0;
    bool met = false;
    for (int r = row - 1; r <= row + 1; ++r)
      for (int c = column - 1; c <= column + 1; ++c) {
        const auto bin = bins_.find({r, (c + 180) % 180});
        if (bin == bins_.end()) continue;
        const auto [low, high] = std::minmax_element(bin->second.begin(), bin->second.end());
        nearest = std::min(nearest, *low);
        farthest = std::max(farthest, *high);
        met |= std::abs(range - *low) < tolerance || std::abs(range - *high) < tolerance;
      }
    if (range < nearest - tolerance) return Sight::through;
    return met && range < farthest + tolerance ? Sight::hit : Sight::unknown;
  }

 private:
  static std::pair<int, int> bin_of(const Eigen::Vector3f& p) {
    const float per_rad = 90 / std::numbers::pi_v<float>;
    return {static_cast<int>(std::floor(std::atan2(p.z(), p.head<2>().norm()) * per_rad + 22.5F)),
            static_cast<int>(std::floor(std::atan2(p.y(), p.x()) * per_rad) + 90) % 180};
  }
  std::map<std::pair<int, int>, std::vector<float>> bins_;
};

TEST(SightImage, SaysWhatAPlainReadingOfTheSweepSays) {
  const BoxMine mine({BoxMine::drift(-20, 0, 20, 0), BoxMine::drift(4, 0, 4, 15)});
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> along(-25, 25), across(-8, 16), up(-2, 4);
  std::array<int, 3> seen{};
  int differ = 0, asked = 0;
  for (const int beams : {16, 64}) {
    const Points sweep = mine.scan(pose_from_yaw(0, {0, 0, 1}), rng, 0, beams, 720);
    const SightImage image(sweep);
    const PlainReading plain(sweep);
    for (; asked < 5000 * (beams == 16 ? 1 : 2); ++asked) {
      const Eigen::Vector3f p(along(rng), across(rng), up(rng));
      const Sight sight = image.look(p, 20);
      differ += static_cast<int>(sight != plain.look(p, 20));
      ++seen.at(static_cast<std::size_t>(sight));
    }
  }
  EXPECT_LT(differ, asked / 200) << "but for points on the edge of a bin";
  for (const int of_each : seen) EXPECT_GT(of_each, 200);
}

}  // namespace
}  // namespace headframe
