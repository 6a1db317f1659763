#include "server/merge/like_places.hpp"

#include <gtest/gtest.h>

#include "server/merge/pair_findings.hpp"

namespace headframe {
namespace {

/// A place at `here` that fits, as a copy would, where it is moved along x.
ScreeningResult fitting(const Eigen::Vector3d& here, double along_m) {
  ScreeningResult out;
  Registration& r = out.place.registration;
  r.status = RegistrationStatus::converged;
  r.T_target_source = Pose(Eigen::Translation3d(along_m, 0, 0));
  r.inlier_fraction = 1;
  out.place.p_b = here;
  out.place.matched = {1000, 1000};
  out.place.residual_m = 0.02;
  r.direction_hold.setConstant(0.2);
  out.place.a_by_b.seen = out.place.b_by_a.seen = 1000;
  out.hopeful = true;
  return out;
}

SelfLikeness counted(std::vector<LikePlace> places) {
  SelfLikeness out;
  out.places = std::move(places);
  count_places(out);
  return out;
}

TEST(LikePlaces, PlacesOfOnePlacementAreOneLikeness) {
  const std::vector<ScreeningResult> screened{fitting({0, 0, 0}, 50), fitting({10, 0, 0}, 51), fitting({0, 0, 0}, 90),
                                              fitting({0, 0, 0}, 1)};
  ASSERT_GT(likeness(screened[0]), 0);
  const auto places = like_places(screened, {0, 1});
  ASSERT_EQ(places.size(), 3U) << "a session lies on itself at the identity";
  EXPECT_EQ(places[0].placement, places[1].placement);
  EXPECT_NE(places[0].placement, places[2].placement);
  EXPECT_EQ(places[1].there, Eigen::Vector3d(61, 0, 0));
  const SelfLikeness all = counted(places);
  EXPECT_EQ(all.look_alikes, likeness(screened[0]) + likeness(screened[2]));
  EXPECT_EQ(all.similar_places, resemblance(screened[0]) + resemblance(screened[2]));
  EXPECT_EQ(all.aliases, 2) << "each place of a copy counts";
}

TEST(LikePlaces, OnlyWhatLiesWhereTheSessionsMeetCounts) {
  const std::vector<KeyframePosition> meeting{{0, {0, 0, 0}}, {1, {20, 0, 0}}};
  const auto at = [&](const Eigen::Vector3d& here, const Eigen::Vector3d& there) {
    return likeness_at(counted({{here, there, 1, 0.5, 0.75, true}}), meeting).look_alikes;
  };
  EXPECT_EQ(at({31.9, 0, 0}, {90, 0, 0}), 0.5);
  EXPECT_EQ(at({32.1, 0, 0}, {90, 0, 0}), 0);
  EXPECT_EQ(at({90, 0, 0}, {0, 11.9, 0}), 0.5) << "the place it is like may lie there as well";
  EXPECT_EQ(at({90, 0, 0}, {0, 0, 12.1}), 0) << "another level";
}

TEST(LikePlaces, ThePlaceWithinReachCountsThoughAnotherOfItsPlacementFitsBetter) {
  const SelfLikeness all =
      counted({{{0, 0, 0}, {90, 0, 0}, 1, 0.25, 0.5, false}, {{40, 0, 0}, {130, 0, 0}, 1, 1, 1, true}});
  EXPECT_EQ(all.look_alikes, 1);
  const std::vector<KeyframePosition> meeting{{0, {0, 0, 0}}};
  const SelfLikeness here = likeness_at(all, meeting);
  EXPECT_EQ(here.look_alikes, 0.25);
  EXPECT_EQ(here.similar_places, 0.5);
  EXPECT_EQ(here.aliases, 0);
  EXPECT_EQ(here.path_m, all.path_m);
}

TEST(LikePlaces, AllCountsIfNobodyKnowsWhereItIs) {
  SelfLikeness of_before;  // as databases have it that an earlier version wrote
  of_before.aliases = 2;
  of_before.look_alikes = 3;
  const std::vector<KeyframePosition> meeting{{0, {0, 0, 0}}};
  EXPECT_EQ(likeness_at(of_before, meeting), of_before);
  const SelfLikeness known = counted({{{90, 0, 0}, {130, 0, 0}, 1, 1, 1, true}});
  EXPECT_EQ(likeness_at(known, {}), known) << "paths that come nowhere near each other";
}

TEST(LikePlaces, AServerThatSearchesForAnotherPassesThemOn) {
  PairFindings findings;
  findings.itself = counted({{{1, 2, 3}, {4, 5, 6}, 7, 0.25, 0.5, true}, {{1, 2, 3}, {8, 9, 10}, 8, 0.75, 1, false}});
  const auto passed_on = decode_findings(encode_findings(findings));
  ASSERT_TRUE(passed_on);
  EXPECT_EQ(passed_on->itself, findings.itself);
}

TEST(LikePlaces, TheMoreIsDrivenWithoutALikePlaceTheFewerAreToBeExpected) {
  SelfLikeness a = counted({{{0, 0, 0}, {90, 0, 0}, 1, 0.5, 0.5, false}}), b = counted({});
  Evidence e;  // no descriptors
  EXPECT_EQ(expected_look_alikes(0.4, b, b, e), 0.4) << "nothing was searched";
  a.path_m = b.path_m = 200;
  EXPECT_NEAR(expected_look_alikes(0.4, b, b, e), 0.8 / 6, 1e-12);
  EXPECT_NEAR(expected_look_alikes(0.4, a, b, e), 1.3 / 6, 1e-12);
  EXPECT_NEAR(expected_look_alikes(0, a, b, e), 0.5 / 6, 1e-12);
  b.wanted = {{1, 7}};
  EXPECT_NEAR(expected_look_alikes(0.4, a, b, e), 1.3 / 4, 1e-12) << "a closer look may find some";
}

TEST(LikePlaces, WhatWasNotSearchedMayHoldSimilarPlaces) {
  EXPECT_EQ(expected_similar_places(0, 0), 0.5) << "nothing was searched";
  EXPECT_NEAR(expected_similar_places(0, 100), 0.25, 1e-12);
  EXPECT_NEAR(expected_similar_places(0, 199), 0.0025, 1e-12);
  EXPECT_EQ(expected_similar_places(0, 200), 0);
  EXPECT_NEAR(expected_similar_places(1, 100), 0.75, 1e-12);
  EXPECT_NEAR(expected_similar_places(1, 200), 0.5, 1e-12);
  EXPECT_NEAR(expected_similar_places(1, 400), 0.25, 1e-12)
      << "those of a long path are no more than those of a short one";
}

TEST(LikePlaces, WhereDescriptorsDifferAsManyAreToBeExpectedAsAnywhere) {
  SelfLikeness a = counted({});
  a.path_m = 100;
  const auto expected = [&](double descriptors, double alike, double of_mine) {
    Evidence e;
    e.descriptors_compared = descriptors;
    e.descriptors_alike = alike;
    return expected_look_alikes(of_mine, a, a, e);
  };
  EXPECT_NEAR(expected(4, 0.77, 0.4), 0.2, 1e-12);
  EXPECT_NEAR(expected(4, 0.74, 0.4), 0.3, 1e-12);
  EXPECT_NEAR(expected(4, 0.71, 0.4), 0.4, 1e-12);
  EXPECT_NEAR(expected(2, 0.6, 0.4), 0.2, 1e-12) << "two tell little";
  a = counted({{{0, 0, 0}, {90, 0, 0}, 1, 0.5, 0.5, false}});
  a.path_m = 100;
  EXPECT_NEAR(expected(4, 0.71, 0), 0.25, 1e-12) << "but never fewer than are seen";
}

}  // namespace
}  // namespace headframe
