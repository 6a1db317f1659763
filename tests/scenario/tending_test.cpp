// Sessions that are archived, restored and frozen, in drawn mines.
#include <gtest/gtest.h>

#include "tests/scenario/drawn_base.hpp"

namespace headframe {
namespace {

using test::Base;

struct ThreeDrives : Base {
  ThreeDrives() : Base({test::drive_a_to_c(1), test::drive_b_to_a(1), test::drive_a_to_c(5)}) {
    for (const SessionId id : {1, 2, 3}) pipeline.attempt(id, shelf);
  }
};

Pose placed_at(const Atlas& atlas, SessionId session) {
  for (const Component& c : atlas.components)
    if (const Placement* p = placement_in(c, session)) return p->T_component_session;
  ADD_FAILURE() << "session " << session << " is nowhere";
  return Pose::Identity();
}

AttemptReport bring_back(Base& base, SessionId id) {
  base.pipeline.add_session(id, ScanContext().id());
  for (const Keyframe& keyframe : base.drive(id).keyframes) base.pipeline.add_keyframe(id, keyframe);
  base.pipeline.complete_session(id);
  return base.pipeline.come_back(id);
}

TEST(Tending, WhatComesBackLiesWhereItLay) {
  ThreeDrives base;
  const Atlas was = base.pipeline.atlas();
  ASSERT_EQ(was.components.size(), 1U);
  base.pipeline.set_aside(2);
  EXPECT_EQ(base.pipeline.atlas().components[0].placements.size(), 2U);
  AttemptReport report = bring_back(base, 2);
  EXPECT_TRUE(report.atlas_changed);
  for (int i = 0; i < 5; ++i) report = base.pipeline.attempt(2, base.shelf);
  const Atlas is = base.pipeline.atlas();
  ASSERT_EQ(is.components.size(), 1U);
  for (const SessionId id : {1, 2, 3})
    EXPECT_LT((placed_at(is, id).translation() - placed_at(was, id).translation()).norm(), 0.05) << id;
}

TEST(Tending, AFrozenSessionHoldsTheFrameAndOthersAlignToIt) {
  Base base({test::drive_a_to_c(1), test::drive_b_to_a(1)});
  EXPECT_EQ(base.pipeline.freeze(9).error().code, ErrorCode::not_found);
  const auto frozen = base.pipeline.freeze(2);
  ASSERT_TRUE(frozen) << frozen.error().message;
  EXPECT_EQ(frozen->frozen.at(0).session, 2);
  EXPECT_EQ(frozen->anchored, 2);
  EXPECT_EQ(base.pipeline.freeze(2).error().code, ErrorCode::refused) << "it is already";
  for (const SessionId id : {1, 2}) base.pipeline.attempt(id, base.shelf);
  ASSERT_EQ(base.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(base.pipeline.atlas().components[0].id, 2) << "session 1 aligns to it";
  EXPECT_EQ(base.pipeline.anchor(1).error().code, ErrorCode::refused);
  const auto also = base.pipeline.freeze(1);
  ASSERT_TRUE(also);
  EXPECT_EQ(also->frozen.at(0).frame, 2);
  EXPECT_EQ(also->anchored, 0) << "the map has its anchor";
  const Pose T_2_1 = placed_at(base.pipeline.atlas(), 1);
  base.arrive(test::drive_a_to_c(5));
  base.pipeline.attempt(3, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components[0].placements.size(), 3U);
  EXPECT_TRUE(placed_at(base.pipeline.atlas(), 1).isApprox(T_2_1, 1e-9)) << "a third moves neither";
  ASSERT_TRUE(base.pipeline.thaw(2));
  EXPECT_EQ(base.pipeline.atlas().components[0].id, 1) << "the one that is still frozen";
  EXPECT_EQ(base.pipeline.thaw(2).error().code, ErrorCode::refused);
  ASSERT_TRUE(base.pipeline.thaw(1));
  EXPECT_TRUE(base.pipeline.anchor(3));
}

TEST(Tending, WhatIsFrozenIsSoAfterARestart) {
  ThreeDrives base;
  const auto one = base.pipeline.freeze(3), other = base.pipeline.freeze(1);
  ASSERT_TRUE(one && other);
  Base later({base.drive(1), base.drive(2), base.drive(3)});
  later.pipeline.restore_frozen({one->frozen[0], other->frozen[0]});
  later.pipeline.restore(base.pipeline.alignments(), base.pipeline.atlas().revision, {}, {one->anchored});
  ASSERT_EQ(later.pipeline.atlas().components.size(), 1U);
  EXPECT_EQ(later.pipeline.atlas().components[0].id, 3);
  EXPECT_TRUE(placed_at(later.pipeline.atlas(), 1).isApprox(placed_at(base.pipeline.atlas(), 1), 1e-9));
}

TEST(Tending, ASessionWithoutKeyframesIsNotFrozen) {
  MergePipeline pipeline{MergeConfig()};
  pipeline.add_session(1, ScanContext().id());
  const auto frozen = pipeline.freeze(1);
  ASSERT_FALSE(frozen);
  EXPECT_EQ(frozen.error().code, ErrorCode::refused);
}

}  // namespace
}  // namespace headframe
