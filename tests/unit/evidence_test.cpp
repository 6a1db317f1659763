#include <gtest/gtest.h>

#include "server/registration/verification.hpp"
#include "server/registration/visibility.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;

std::vector<PlacedCloud> placed(const test::Drive& drive) {
  std::vector<PlacedCloud> out;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
    out.push_back(
        {i + 1, drive.keyframes[i].T_local_sensor, std::make_shared<PreparedCloud>(prepare(drive.clouds[i]))});
  return out;
}

TEST(RangeImage, HitThroughAndHidden) {
  const BoxMine room({{{-5, -5, -1}, {5, 5, 2}}});
  std::mt19937 rng(1);
  const RangeImage image(room.scan(Pose::Identity(), rng, 0, 64, 360));
  const float tolerance = 0.35F + 0.03F * 5;
  EXPECT_EQ(image.look({5, 0, 0}, 30), Sight::hit);
  EXPECT_EQ(image.look({5 - 0.8F * tolerance, 0, 0}, 30), Sight::hit);
  EXPECT_EQ(image.look({5 - 1.6F * tolerance, 0, 0}, 30), Sight::through);
  EXPECT_EQ(image.look({5 + 2 * tolerance, 0, 0}, 30), Sight::unknown) << "behind the wall";
  EXPECT_EQ(image.look({2, 0, 0}, 1.9F), Sight::unknown) << "out of reach";
  EXPECT_EQ(image.look({0.1F, 0, 3}, 30), Sight::unknown) << "above the field of view";
  EXPECT_EQ(RangeImage(Points{}).look({1, 0, 0}, 30), Sight::unknown);
}

TEST(Submap, RadiusFollowsThePaper) {
  EXPECT_DOUBLE_EQ(sphere_radius_m(12), 25);
  EXPECT_DOUBLE_EQ(sphere_radius_m(10), 25);
  EXPECT_DOUBLE_EQ(sphere_radius_m(6), 15);
  EXPECT_DOUBLE_EQ(sphere_radius_m(3), 10);
  EXPECT_DOUBLE_EQ(sphere_radius_m(2), 4);
}

TEST(Submap, AVehicleThatDroveOnIsLeftOut) {
  const BoxMine drift({BoxMine::drift(-20, 0, 20, 0)});
  auto d = drive(drift, {{-6, 0}, {6, 0}}, 0, 1, 2);
  for (int i = 0; i < 200; ++i)  // one keyframe sees a vehicle 4 m ahead that none of the others does
    d.clouds[1].sweeps[0].points.emplace_back(4, -0.5F + 0.005F * static_cast<float>(i), 0.0F);
  const auto clouds = placed(d);
  const Eigen::Vector3d vehicle = d.keyframes[1].T_local_sensor * Eigen::Vector3d(4, 0, 0);
  double nearest = 1e9;
  for (const auto& p : merged(clouds, 0.25F)) nearest = std::min(nearest, (p.cast<double>() - vehicle).norm());
  EXPECT_GT(nearest, 0.8);
  for (const auto& p : sphere(clouds, vehicle, 5, 0.25F)) EXPECT_LT((p.cast<double>() - vehicle).norm(), 5.001);
}

TEST(Visibility, TheRightPlaceHasNoViolationsAndAWrongOneHas) {
  const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30)});
  const auto a = drive(mine, {{5, 0}, {45, 0}}, 0, 1), b = drive(mine, {{30, 25}, {30, 0}, {15, 0}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const Points points = merged(placed(b), 0.5F);
  EXPECT_LT(look_from(placed(a), points, truth, 30, 1).violation(), 0.002);
  const Pose wrong = Eigen::Translation3d(0, 6, 0) * truth;
  EXPECT_GT(look_from(placed(a), points, wrong, 30, 1).violation(), 0.02);
  EXPECT_EQ(look_from(placed(a), points, wrong, 30, 1).violated, look_from(placed(a), points, wrong, 30, 3).violated);
}

TEST(Judge, TellsTheRightPlaceFromAWrongOne) {
  const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30), BoxMine::drift(10, -20, 10, 0, 6)});
  const auto a = drive(mine, {{5, 0}, {45, 0}}, 0, 1), b = drive(mine, {{30, 25}, {30, 0}, {15, 0}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const auto clouds_a = placed(a), clouds_b = placed(b);
  const Judgement right = judge(clouds_a, clouds_b, truth * pose_from_yaw(0.1, {0.7, -0.6, 0}), {});
  EXPECT_GT(right.evidence.probability, 0.9);
  EXPECT_LT((right.T_a_b.translation() - truth.translation()).norm(), 0.05);
  const Judgement wrong = judge(clouds_a, clouds_b, Eigen::Translation3d(-20, 0, 0) * truth, {});
  EXPECT_LT(wrong.evidence.probability, 0.5);
  EXPECT_EQ(judge({}, clouds_b, truth, {}).status, RegistrationStatus::too_little_overlap);
  EXPECT_EQ(judge(clouds_a, clouds_b, Eigen::Translation3d(500, 0, 0) * truth, {}).status,
            RegistrationStatus::too_little_overlap);
}

}  // namespace
}  // namespace headframe
