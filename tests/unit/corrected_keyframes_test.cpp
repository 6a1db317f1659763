#include "client/keyframe/corrected_keyframes.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace headframe {
namespace {

Pose at(double x_m, double y_m = 0, double yaw_rad = 0) { return pose_from_yaw(yaw_rad, {x_m, y_m, 0}); }

/// Each 10 s, 10 m apart.
std::vector<KnownKeyframe> keyframes(int count) {
  std::vector<KnownKeyframe> all;
  all.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) all.push_back({10.0 * i, at(10.0 * i), 5});
  return all;
}

std::vector<std::uint64_t> sequences(const CorrectedKeyframes& found) {
  std::vector<std::uint64_t> all;
  for (const KeyframePose& pose : found.moved) all.push_back(pose.sequence);
  return all;
}

TEST(CorrectedKeyframes, OfTheSameStampLieWhereTheTrajectorySaysIfTheyMovedByEnough) {
  const auto found = corrected_keyframes(
      keyframes(4), std::vector<TrajectoryPose>{
                        {0, at(0.049)}, {10.0009, at(10.05)}, {20, at(20, 0, 0.0099)}, {30, at(30, 0, 0.01)}});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->matched, 4U);
  EXPECT_EQ(sequences(*found), (std::vector<std::uint64_t>{2, 4}));
  EXPECT_TRUE(found->moved[0].T_local_sensor.isApprox(at(10.05)));
  EXPECT_TRUE(found->moved[1].T_local_sensor.isApprox(at(30, 0, 0.01)));
}

TEST(CorrectedKeyframes, BetweenTwoPosesThatAreNearInTimeOrSpaceLieBetweenThem) {
  const auto matched = [](double gap_s, double gap_m) {
    const std::vector<TrajectoryPose> trajectory{{10 - gap_s / 2, at(10 - gap_m / 2, 2)},
                                                 {10 + gap_s / 2, at(10 + gap_m / 2, 4)}};
    const auto found = corrected_keyframes(keyframes(3), trajectory, {.most_gap_m = 5});
    EXPECT_TRUE(found);
    if (found->matched == 1) {
      EXPECT_TRUE(found->moved.at(1).T_local_sensor.isApprox(at(10, 3)));
    }
    return found->matched;
  };
  EXPECT_EQ(matched(0.99, 40), 1U);
  EXPECT_EQ(matched(1.01, 40), 0U);
  EXPECT_EQ(matched(8, 4), 1U);  // 4.5 m with the 2 m aside
  EXPECT_EQ(matched(8, 4.6), 0U);
}

TEST(CorrectedKeyframes, ThoseThatTheTrajectoryHasNoPoseForMoveAsThoseAroundThem) {
  const std::vector<TrajectoryPose> trajectory{{10, at(10, 1)}, {30, at(30, 3)}};
  const auto found = corrected_keyframes(keyframes(6), trajectory);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->matched, 2U);
  const double y[] = {1, 1, 2, 3, 3, 3};
  ASSERT_EQ(found->moved.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_TRUE(found->moved[i].T_local_sensor.isApprox(at(10.0 * static_cast<double>(i), y[i]))) << i;
  const auto without = corrected_keyframes(keyframes(6), trajectory, {.later_ones = false});
  EXPECT_EQ(sequences(*without), (std::vector<std::uint64_t>{1, 2, 3, 4})) << "later ones are in the new frame already";
}

TEST(CorrectedKeyframes, AnotherFrameTurnsAllOfThem) {
  const Pose T_new_old = pose_from_yaw(1.2, {100, -50, 3});
  std::vector<TrajectoryPose> trajectory;
  for (const KnownKeyframe& k : keyframes(9)) trajectory.push_back({k.stamp_s, T_new_old * k.T_local_sensor});
  trajectory.erase(trajectory.begin() + 4);
  const auto found = corrected_keyframes(keyframes(9), trajectory);
  ASSERT_EQ(found->moved.size(), 9U);
  for (const KeyframePose& pose : found->moved)
    EXPECT_TRUE(pose.T_local_sensor.isApprox(T_new_old * at(10.0 * static_cast<double>(pose.sequence - 1)), 1e-9));
}

TEST(CorrectedKeyframes, ATrajectoryOfOtherTimesMovesNothingAndOneThatIsNoneIsRefused) {
  const auto other = corrected_keyframes(keyframes(3), std::vector<TrajectoryPose>{{1000, at(5)}, {1001, at(6)}});
  ASSERT_TRUE(other);
  EXPECT_EQ(other->matched, 0U);
  EXPECT_TRUE(other->moved.empty());
  EXPECT_TRUE(corrected_keyframes({}, std::vector<TrajectoryPose>{{1, at(5)}})->moved.empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<TrajectoryPose>& wrong : {std::vector<TrajectoryPose>{{1, at(0)}, {1, at(1)}},
                                                   {{2, at(0)}, {1, at(1)}},
                                                   {{1, at(nan)}},
                                                   {{nan, at(1)}}}) {
    const auto refused = corrected_keyframes(keyframes(3), wrong);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  }
}

}  // namespace
}  // namespace headframe
