#include "server/verification/change_patches.hpp"

#include <gtest/gtest.h>

#include "server/verification/evidence.hpp"

namespace headframe {
namespace {

constexpr float leaf_m = 0.5F;
const Dates a_month{false, 1.7e9, 1.7026e9};

/*  A drift along x, 4 m wide: two walls, floor and roof of points half a metre apart, all of them seen.  */
AskedRock drift(float from_m, float to_m) {
  AskedRock out;
  for (float x = from_m; x < to_m; x += leaf_m) {
    for (float z = 0; z < 3; z += leaf_m)
      for (const float y : {-2.0F, 2.0F}) out.points.emplace_back(x, y, z);
    for (float y = -1.5F; y < 2; y += leaf_m)
      for (const float z : {0.0F, 3.0F}) out.points.emplace_back(x, y, z);
  }
  out.sights.assign(out.points.size(), PointSight::seen);
  return out;
}

/// The wall at y = 2 from one x to another, up to a height, is violated.
void open_wall(AskedRock& rock, float from_m, float to_m, float height_m = 10) {
  for (std::size_t i = 0; i < rock.points.size(); ++i) {
    const Eigen::Vector3f& p = rock.points[i];
    if (p.y() == 2 && p.x() >= from_m && p.x() < to_m && p.z() < height_m) rock.sights[i] = PointSight::violated;
  }
}

TEST(ChangePatches, AnOpeningInAWallIsOnePatchWithItsKind) {
  AskedRock a = drift(-10, 10), b = drift(-10, 10);
  open_wall(a, -2, 2);
  const auto patches = find_patches(a, b, leaf_m, a_month);
  ASSERT_EQ(patches.size(), 1U);
  EXPECT_EQ(patches[0].points.size(), 48U);
  EXPECT_FALSE(patches[0].free_standing);
  EXPECT_EQ(patches[0].kind, ChangeKind::excavated) << "a is older: b's rays pass through its rock";
  EXPECT_EQ(find_patches(b, a, leaf_m, a_month).at(0).kind, ChangeKind::filled) << "b is newer: a's rays once passed";
  EXPECT_EQ(find_patches(a, b, leaf_m, {true, 1.7e9, 1.8e9}).at(0).kind, ChangeKind::filled);
  const Change change = change_of(patches[0]);
  EXPECT_NEAR(change.p_a.x(), -0.25, 1e-3);
  EXPECT_NEAR(change.p_a.y(), 2, 1e-3);
  EXPECT_NEAR(change.length_m, 3.5, 1e-3);
  EXPECT_NEAR(change.width_m, 0, 1e-3);
  EXPECT_NEAR(change.height_m, 2.5, 1e-3);
  EXPECT_EQ(change.older_s, a_month.older_s);
  EXPECT_EQ(change.newer_s, a_month.newer_s);
}

TEST(ChangePatches, AWallThatIsViolatedAsFarAsAnythingIsKnownHasNoEdge) {
  AskedRock a = drift(-10, 10);
  open_wall(a, -10, 10);
  EXPECT_TRUE(find_patches(a, drift(-10, 10), leaf_m, a_month).empty());
  AskedRock to_the_end = drift(-10, 10);
  open_wall(to_the_end, 2, 10);
  EXPECT_TRUE(find_patches(to_the_end, drift(-10, 10), leaf_m, a_month).empty()) << "an edge on one side is none";
}

TEST(ChangePatches, SmallOrThinOnesAreNone) {
  const auto patches = [](float to_m, float height_m) {
    AskedRock a = drift(-10, 10);
    open_wall(a, 0, to_m, height_m);
    return find_patches(a, drift(-10, 10), leaf_m, a_month).size();
  };
  EXPECT_EQ(patches(2, 1.5F), 1U) << "12 points, 3 square metres";
  EXPECT_EQ(patches(1.5F, 1.5F), 0U) << "9 points, 2.25 square metres";
  AskedRock sparse = drift(-10, 10);
  open_wall(sparse, -4, 4);
  for (std::size_t i = 0; i < sparse.points.size(); ++i)  // every third of the wall
    if (sparse.sights[i] == PointSight::violated && i % 3 != 0) sparse.sights[i] = PointSight::seen;
  EXPECT_TRUE(find_patches(sparse, drift(-10, 10), leaf_m, a_month).empty()) << "not dense";
}

TEST(ChangePatches, WhereTheSurroundingsContradictTooItIsNone) {
  AskedRock a = drift(-10, 10);
  open_wall(a, -2, 2);
  for (std::size_t i = 0; i < a.points.size(); ++i)
    if (a.points[i].y() < 1 && i % 3 == 0) a.sights[i] = PointSight::violated;
  EXPECT_TRUE(find_patches(a, drift(-10, 10), leaf_m, a_month).empty());
}

ChangePatch patch(ChangeKind kind, float x_m, bool free_standing = false) {
  ChangePatch out{{}, kind, free_standing, a_month};
  for (float y = 0; y < 3; y += leaf_m)
    for (float z = 0; z < 2; z += leaf_m) out.points.emplace_back(x_m, y, z);
  return out;
}

TEST(ChangePatches, FewWallsOfOneKindArePlausible) {
  const ChangePatch gone = patch(ChangeKind::excavated, 0), came = patch(ChangeKind::filled, 9),
                    machine = patch(ChangeKind::filled, 20, true);
  const auto is_plausible = [](const std::vector<ChangePatch>& all) { return plausible(all); };
  EXPECT_TRUE(is_plausible({}));
  EXPECT_TRUE(is_plausible({gone, patch(ChangeKind::excavated, 30)}));
  EXPECT_TRUE(is_plausible({gone, machine}));
  EXPECT_FALSE(is_plausible({gone, came})) << "as where a copy of a mine ends";
  EXPECT_TRUE(is_plausible({gone, gone, gone}));
  EXPECT_FALSE(is_plausible({gone, gone, gone, gone})) << "as at a wrong placement";
}

TEST(ChangePatches, ThoseThatTouchAreOne) {
  ChangePatch later = patch(ChangeKind::excavated, 1.4F);
  later.dates.older_s += 100;
  later.dates.newer_s -= 100;
  const auto one = joined({patch(ChangeKind::excavated, 0), patch(ChangeKind::excavated, 2.8F), later});
  ASSERT_EQ(one.size(), 1U) << "the third joins the first two";
  EXPECT_EQ(one[0].dates.older_s, a_month.older_s + 100);
  EXPECT_EQ(one[0].dates.newer_s, a_month.newer_s - 100);
  EXPECT_EQ(joined({patch(ChangeKind::excavated, 0), patch(ChangeKind::excavated, 1.6F)}).size(), 2U);
  EXPECT_EQ(joined({patch(ChangeKind::excavated, 0), patch(ChangeKind::filled, 0)}).size(), 2U);
}

TEST(Recorded, OnlyDatesAnHourApartTellOlderFromNewer) {
  const Recorded a{1.7e9, 1.7e9 + 60};
  EXPECT_FALSE(dates_of(a, {a.to_s + 3599, a.to_s + 4000}));
  const auto dates = dates_of(a, {a.to_s + 3600, a.to_s + 4000});
  ASSERT_TRUE(dates);
  EXPECT_FALSE(dates->a_is_newer);
  EXPECT_EQ(dates->older_s, a.to_s);
  EXPECT_EQ(dates->newer_s, a.to_s + 3600);
  EXPECT_TRUE(dates_of({a.to_s + 3600, a.to_s + 4000}, a)->a_is_newer);
  EXPECT_FALSE(dates_of(a, {})) << "no date";
  EXPECT_FALSE(is_date(12)) << "since the robot's start";
  EXPECT_FALSE(is_date(1.7e12)) << "milliseconds";
  EXPECT_TRUE(is_date(1.7e9));
}

TEST(Recorded, AChangeSeenFromTheOtherSessionIsTheSame) {
  const Pose T_a_b = pose_from_yaw(0.7, {3, -2, 1});
  const Change change{ChangeKind::filled, {5, 6, 7}, 1, 2, 3, true, 1, 2};
  const Change turned = seen_from_b(change, T_a_b);
  EXPECT_LT((T_a_b * turned.p_a - change.p_a).norm(), 1e-12);
  EXPECT_FALSE(turned.a_is_newer);
  EXPECT_LT((seen_from_b(turned, T_a_b.inverse()).p_a - change.p_a).norm(), 1e-12);
}

TEST(Evidence, ChangesExcuseNothingWhereTheMineRepeatsItself) {
  Evidence e;
  e.freespace_violation = 0.01;
  e.freespace_explained = 0.008;
  e.worst_place_violation = 0.02;
  e.worst_place_explained = 0.02;
  e.farther_violation = 0.005;
  EXPECT_NEAR(freespace_contradiction(e), 0.0012, 1e-12) << "the rim of a patch is excused with it";
  EXPECT_NEAR(worst_place_contradiction(e), 0, 1e-12);
  EXPECT_EQ(farther_contradiction(e), 0.005);
  for (double Evidence::*member : {&Evidence::aliases, &Evidence::repetition, &Evidence::look_alikes}) {
    Evidence repeats = e;
    repeats.*member = 2;
    EXPECT_EQ(freespace_contradiction(repeats), 0.01);
    EXPECT_EQ(worst_place_contradiction(repeats), 0.02);
  }
  e.look_alikes = 0.5;
  EXPECT_EQ(excused_by_changes(e), 1);
  e.look_alikes = 0.75;
  EXPECT_NEAR(excused_by_changes(e), 0.5, 1e-12);
}

}  // namespace
}  // namespace headframe
