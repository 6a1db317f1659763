#include "client/keyframe/keyframe_selector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

namespace headframe {
namespace {

constexpr double degree = std::numbers::pi / 180;

Pose at(double x_m, double y_m = 0, double yaw_deg = 0) { return pose_from_yaw(yaw_deg * degree, {x_m, y_m, 0}); }

TEST(KeyframeSelector, ThresholdFollowsTheSpaciousness) {
  EXPECT_DOUBLE_EQ(distance_threshold_m(10.001F), 10);
  EXPECT_DOUBLE_EQ(distance_threshold_m(10.0F), 6);
  EXPECT_DOUBLE_EQ(distance_threshold_m(6.001F), 6);
  EXPECT_DOUBLE_EQ(distance_threshold_m(6.0F), 3);
  EXPECT_DOUBLE_EQ(distance_threshold_m(3.001F), 3);
  EXPECT_DOUBLE_EQ(distance_threshold_m(3.0F), 3);
  EXPECT_DOUBLE_EQ(distance_threshold_m(2.0F), 2);
}

TEST(KeyframeSelector, SpaciousnessIsTheFilterOfThePaper) {
  KeyframeSelector selector;
  double s = 20;
  EXPECT_FLOAT_EQ(selector.add(at(0), 20).spaciousness_m, 20) << "the first scan starts the filter";
  for (const float S : {4.0F, 8.0F, 100.0F}) {
    s = 0.9 * s + 0.1 * S;
    EXPECT_NEAR(selector.add(at(0), S).spaciousness_m, s, 1e-4);
  }
  for (const float nothing : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_NEAR(selector.add(at(0), nothing).spaciousness_m, s, 1e-4) << "an empty scan says nothing of the room";
}

TEST(KeyframeSelector, MeanRangeIsOverDistances) {
  EXPECT_FLOAT_EQ(mean_range_m({{3, 4, 0}, {0, 0, -1}}), 3);
  EXPECT_FLOAT_EQ(mean_range_m({}), 0);
}

TEST(KeyframeSelector, DistanceThresholdFromBothSides) {
  const struct {
    float spaciousness_m;
    double threshold_m;
  } rooms[] = {{30, 10}, {8, 6}, {4, 3}, {2, 2}, {0.1F, 0.5}};
  for (const auto& room : rooms) {
    KeyframeSelector selector;
    EXPECT_TRUE(selector.add(at(0), room.spaciousness_m).keyframe) << "the first scan";
    EXPECT_FALSE(selector.add(at(room.threshold_m - 0.001), room.spaciousness_m).keyframe) << room.threshold_m;
    EXPECT_TRUE(selector.add(at(room.threshold_m), room.spaciousness_m).keyframe) << room.threshold_m;
    EXPECT_FALSE(selector.add(at(2 * room.threshold_m - 0.001), room.spaciousness_m).keyframe) << room.threshold_m;
  }
}

TEST(KeyframeSelector, RotationThresholdFromBothSides) {
  KeyframeSelector selector;
  selector.add(at(0), 30);
  EXPECT_FALSE(selector.add(at(0, 0, 29.99), 30).keyframe);
  EXPECT_TRUE(selector.add(at(0, 0, 30), 30).keyframe);
  EXPECT_FALSE(selector.add(at(0, 0, 59.99), 30).keyframe) << "measured from the last keyframe";
  EXPECT_TRUE(selector.add(at(1, 0, -150), 30).keyframe);
}

TEST(KeyframeSelector, AFullTurnOnTheSpotMakesTwelveAndTheSecondTurnNone) {
  KeyframeSelector selector;
  int keyframes = 0;
  for (int i = 0; i < 720; ++i) {
    if (i == 360) {
      EXPECT_EQ(keyframes, 12);
    }
    keyframes += selector.add(at(0, 0, i), 30).keyframe ? 1 : 0;
  }
  EXPECT_EQ(keyframes, 12);
}

TEST(KeyframeSelector, AnEarlierKeyframeNearbySuppressesANewOne) {
  KeyframeSelector selector;
  for (int x = 0; x <= 40; x += 10) EXPECT_TRUE(selector.add(at(x), 30).keyframe);
  // Back along the same line, looking the same way: 40 m from the last keyframe, but near an old one.
  EXPECT_FALSE(selector.add(at(10, 9.99), 30).keyframe);
  EXPECT_TRUE(selector.add(at(10, 10), 30).keyframe) << "just out of its reach";
}

TEST(KeyframeSelector, OppositeWayNearAnOldKeyframeCountsAsSeenAnew) {
  KeyframeSelector selector;
  selector.add(at(0), 30);
  selector.add(at(20), 30);
  EXPECT_TRUE(selector.add(at(1, 0, 31), 30).keyframe) << "turned, and nothing nearby looks this way";
  EXPECT_FALSE(selector.add(at(2, 0, 1.5), 30).keyframe) << "turned 29.5 from the last";
  EXPECT_FALSE(selector.add(at(2, 0, 0.5), 30).keyframe) << "turned 30.5, but the first keyframe looks this way";
  EXPECT_TRUE(selector.add(at(2, 0, -30), 30).keyframe);
}

TEST(KeyframeSelector, KnownGroundIsLookedAtAgainAfterTheLoopIsLongEnough) {
  const auto keyframes_on_second_lap = [](double side_m) {
    KeyframeSelector selector;
    int keyframes = 0;
    for (int lap = 0; lap < 2; ++lap) {
      keyframes = 0;
      for (int i = 0; i < 400; ++i) {  // round a square, looking the same way all the time
        const double s = i % 100 / 100.0 * side_m;
        const Pose corners[] = {at(s, 0), at(side_m, s), at(side_m - s, side_m), at(0, side_m - s)};
        keyframes += selector.add(corners[i / 100], 5).keyframe ? 1 : 0;
      }
    }
    return keyframes;
  };
  EXPECT_EQ(keyframes_on_second_lap(22), 1) << "88 m round: one at its end, near the first keyframe of both laps alone";
  EXPECT_EQ(keyframes_on_second_lap(25), 5) << "every 20 m";
  EXPECT_EQ(keyframes_on_second_lap(50), 10);
}

TEST(KeyframeSelector, ARobotAtRestWhosePoseTremblesSendsNothingMore) {
  KeyframeSelector selector;
  EXPECT_TRUE(selector.add(at(0), 30).keyframe);
  for (int i = 0; i < 100000; ++i) ASSERT_FALSE(selector.add(at(i % 2 == 0 ? 0.4 : -0.4), 30).keyframe) << i;
}

/// Random drives, of which random keyframes are moved: it decides as one that was restored by where they lie now.
TEST(KeyframeSelector, WhoseKeyframesWereMovedDecidesAsOneThatWasRestored) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> side(-40, 40), turn(-180, 180), room(1, 12);
    KeyframeSelector moved;
    std::vector<KeyframePose> known;
    std::vector<float> rooms;
    for (int i = 0; i < 300; ++i) {
      const Pose T = at(side(random), side(random), turn(random));
      const auto decision = moved.add(T, static_cast<float>(room(random)));
      if (!decision.keyframe) continue;
      known.push_back({known.size() + 1, T});
      rooms.push_back(decision.spaciousness_m);
    }
    for (int updates = 0; updates < 3; ++updates) {
      std::vector<KeyframePose> update;
      for (KeyframePose& k : known) {
        if (random() % 3 != 0) continue;
        k.T_local_sensor = pose_from_yaw(0.1, {side(random) / 4, side(random) / 4, 0}) * k.T_local_sensor;
        update.push_back(k);
      }
      moved.move(update, rooms.back());
    }
    KeyframeSelector restored;
    for (std::size_t i = 0; i < known.size(); ++i) restored.restore(known[i].T_local_sensor, rooms[i]);
    ASSERT_EQ(moved.size(), restored.size());
    std::size_t chosen = 0;
    for (int i = 0; i < 300; ++i) {
      const Pose T = at(side(random), side(random), turn(random));
      const auto range_m = static_cast<float>(room(random));
      const auto one = moved.add(T, range_m), other = restored.add(T, range_m);
      ASSERT_EQ(one.keyframe, other.keyframe) << "seed " << seed << ", scan " << i;
      EXPECT_EQ(one.spaciousness_m, other.spaciousness_m);
      chosen += one.keyframe ? 1 : 0;
    }
    EXPECT_GT(chosen, 5U);
    EXPECT_LT(chosen, 295U);
  }
}

TEST(KeyframeSelector, KnownGroundIsKnownAfterARestart) {
  KeyframeSelector first, again;
  for (int i = 0; i <= 30; ++i)
    if (const auto chosen = first.add(at(5.0 * i), 4); chosen.keyframe)
      again.restore(at(5.0 * i), chosen.spaciousness_m);
  for (int i = 30; i >= 0; --i)
    ASSERT_EQ(again.add(at(5.0 * i), 4).keyframe, first.add(at(5.0 * i), 4).keyframe) << 5 * i << " m";
}

// The rule, written down again without the grid of cubes: every earlier keyframe is looked at.
TEST(KeyframeSelector, AgreesWithLookingAtEveryKeyframe) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> step_m(-2, 2);
  std::uniform_real_distribution<double> turn_deg(-40, 40);
  KeyframeSelector selector;
  std::vector<Pose> kept;
  std::vector<double> kept_m;
  Pose T = Pose::Identity();
  Eigen::Vector3d path_end(T.translation());
  double path_m = 0;
  int suppressed = 0, on_known_ground = 0;
  for (int i = 0; i < 4000; ++i) {
    T = T * pose_from_yaw(turn_deg(rng) * degree, {step_m(rng) + 0.3, step_m(rng), 0.3 * step_m(rng)});
    if (const double driven_m = (T.translation() - path_end).norm(); i == 0 || driven_m >= 1) {
      path_m += i == 0 ? 0 : driven_m;
      path_end = T.translation();
    }
    const float range_m = 2.0F + static_cast<float>(i % 700) / 35;
    const auto decision = selector.add(T, range_m);
    const double threshold_m = distance_threshold_m(decision.spaciousness_m);
    const auto near = [&](const Pose& k) { return (k.translation() - T.translation()).norm() < threshold_m; };
    const auto same = [&](const Pose& k) { return rotation_angle_rad(k.inverse() * T) < 30 * degree; };
    const bool far = std::none_of(kept.begin(), kept.end(), near);
    const bool new_view = !kept.empty() && !same(kept.back()) &&
                          std::none_of(kept.begin(), kept.end(), [&](const Pose& k) { return near(k) && same(k); });
    bool known = !kept.empty() && path_m - kept_m.back() >= 20;
    for (std::size_t k = 0; k < kept.size(); ++k) known = known && !(near(kept[k]) && path_m - kept_m[k] < 95);
    ASSERT_EQ(decision.keyframe, far || new_view || known) << "scan " << i;
    if (decision.keyframe) {
      kept.push_back(T);
      kept_m.push_back(path_m);
    }
    suppressed += decision.keyframe ? 0 : 1;
    on_known_ground += known && !far && !new_view ? 1 : 0;
  }
  EXPECT_GT(on_known_ground, 20);
  EXPECT_GT(kept.size(), 200U);
  EXPECT_GT(suppressed, 200);
}

TEST(KeyframeSelector, APoseThatIsNoPoseIsNeverAKeyframe) {
  KeyframeSelector selector;
  EXPECT_FALSE(selector.add(at(std::numeric_limits<double>::quiet_NaN()), 30).keyframe);
  EXPECT_FALSE(selector.add(at(1e300), 30).keyframe);
  EXPECT_TRUE(selector.add(at(1e8), 30).keyframe);
}

}  // namespace
}  // namespace headframe
