#include "server/place/sanity.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;

/// Round a corner, past a side drift.
std::vector<Keyframe> driven() {
  static const BoxMine mine(
      {BoxMine::drift(0, 0, 40, 0), BoxMine::drift(40, 0, 40, 40), BoxMine::drift(20, 0, 20, 15)});
  return test::drive(mine, {{2, 0}, {40, 0}, {40, 36}}, 0.7, 3).keyframes;
}

void fill_with_noise(Keyframe& k, unsigned seed) {
  std::mt19937 rng(seed);
  for (auto& code : k.walls.code) code = static_cast<std::uint8_t>(rng() % 255);
}

std::vector<std::size_t> outliers(const std::vector<Keyframe>& keyframes) {
  std::vector<std::size_t> odd;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    if (!fits_neighbours(keyframes, i)) odd.push_back(i);
  return odd;
}

TEST(Sanity, ASoundDriveHasNoOddKeyframe) { EXPECT_EQ(outliers(driven()), std::vector<std::size_t>{}); }

TEST(Sanity, NoiseIsOddAndCondemnsNoNeighbour) {
  const auto sound = driven();
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, std::size_t{7}, sound.size() - 1}) {
    auto spoiled = sound;
    fill_with_noise(spoiled[at], static_cast<unsigned>(at));
    EXPECT_EQ(outliers(spoiled), std::vector<std::size_t>{at});
  }
}

TEST(Sanity, AScanFiledUnderAWrongHeadingIsOdd) {
  auto keyframes = driven();
  keyframes[5].T_local_sensor = keyframes[5].T_local_sensor * pose_from_yaw(1.5, Eigen::Vector3d::Zero());
  EXPECT_EQ(outliers(keyframes), std::vector<std::size_t>{5});
}

TEST(Sanity, WhoHasNobodyToAskIsNotOdd) {
  auto keyframes = driven();
  fill_with_noise(keyframes[1], 4);
  EXPECT_TRUE(fits_neighbours({keyframes.data(), 1}, 0));
  EXPECT_TRUE(fits_neighbours({keyframes.data(), 2}, 1)) << "one neighbour alone: which of the two is wrong?";
  EXPECT_FALSE(fits_neighbours({keyframes.data(), 3}, 1));
}

TEST(Sanity, WithoutProfilesNobodyIsOdd) {
  auto keyframes = driven();
  for (auto& k : keyframes) k.walls = {};
  EXPECT_EQ(outliers(keyframes), std::vector<std::size_t>{});
}

TEST(Sanity, AgreementIsFullWithItselfAndSaysNothingOfTheHidden) {
  const auto keyframes = driven();
  EXPECT_EQ(agreement(keyframes[3], keyframes[3]), 1.0);
  EXPECT_FALSE(agreement(keyframes.front(), keyframes.back())) << "round the corner";
}

}  // namespace
}  // namespace headframe
