// What a store keeps, bit for bit, over both databases.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

using StoreContract = OverBothStores;
OVER_BOTH_STORES(StoreContract);

TEST_P(StoreContract, KeepsRobotsAsTheyWerePutLast) {
  const StoreHome dir(GetParam());
  const RobotRecord ant{"ant", std::string("\0digest\xff", 8), "", 12.5, 3, false, 64},
      bee{"bee", "", "code", 1, 0, true};
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutRobot{bee}));
    ASSERT_TRUE(write_and_wait(*store, PutRobot{{"ant", "old", "code", 1, 2, true}}));
    ASSERT_TRUE(write_and_wait(*store, PutRobot{ant}));
  }
  const auto robots = open(dir)->robots();
  ASSERT_TRUE(robots) << robots.error().message;
  EXPECT_EQ(*robots, (std::vector<RobotRecord>{ant, bee}));
}

TEST_P(StoreContract, KeepsTheLastRunOfASpool) {
  const StoreHome dir(GetParam());
  SessionRecord session = session_record(1, "ant");
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutSession{session}));
    ASSERT_TRUE(write_and_wait(*store, CompleteSession{1}));
    session.spool_run = ~0ULL;  // all bits come back
    ASSERT_TRUE(write_and_wait(*store, PutSession{session}));
  }
  const auto sessions = open(dir)->sessions();
  ASSERT_EQ(sessions->size(), 1U);
  EXPECT_EQ(sessions->front().spool_run, ~0ULL);
  EXPECT_TRUE(sessions->front().complete) << "nothing else changes";
}

TEST_P(StoreContract, KeepsSessionsKeyframesAndCloudsBitForBit) {
  const StoreHome dir(GetParam());
  const SessionRecord session = session_record(1, "ant");
  const Keyframe k = line_keyframe(1);
  const std::string encoded("\0cloud\xff", 7);
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutSession{session}));
    ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, k}));
    ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, 1}, encoded}));
    ASSERT_TRUE(write_and_wait(*store, CompleteSession{1}));
  }
  const auto store = open(dir);
  const auto sessions = store->sessions();
  ASSERT_TRUE(sessions);
  ASSERT_EQ(sessions->size(), 1U);
  const SessionRecord& s = sessions->front();
  EXPECT_EQ(s.key, session.key);
  EXPECT_EQ(s.family, session.family);
  EXPECT_EQ(s.sensor.beams, 32);
  EXPECT_EQ(s.spool_id, 77U);
  EXPECT_TRUE(s.complete);
  const auto all = keyframes(*store, 1);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].T_local_sensor.matrix(), k.T_local_sensor.matrix());
  EXPECT_EQ(all[0].descriptor.q, k.descriptor.q);
  EXPECT_EQ(all[0].descriptor.w, k.descriptor.w);
  EXPECT_EQ(all[0].descriptor.place_class, PlaceClass::tunnel);
  EXPECT_EQ(all[0].walls.code, k.walls.code);
  EXPECT_EQ(all[0].point_count, 1000U);
  EXPECT_EQ(store->cloud({1, 1}).value(), encoded);
  EXPECT_EQ(store->cloud_sequences(1).value(), std::vector<std::uint64_t>{1});
  EXPECT_EQ(store->cloud({1, 2}).error().code, ErrorCode::not_found);
}

TEST_P(StoreContract, KeepsTheAtlasWithItsEvidence) {
  const StoreHome dir(GetParam());
  Alignment alignment{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
  alignment.evidence.probability = 0.97;
  alignment.evidence.end_on_match = std::numeric_limits<double>::quiet_NaN();
  alignment.changes = {{ChangeKind::filled, {1, 2, 3}, 4, 5, 6, true, 1.7e9, 1.8e9},
                       {ChangeKind::excavated, {7, 8, 9}, 1, 1, 1, false, 1.71e9, 1.72e9}};
  const Atlas atlas{4, {{1, {{1, Pose::Identity()}, {2, alignment.T_a_b}}}}};
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{2, 17, {alignment}, atlas, {}}));
    alignment.state = AlignmentState::retracted;
    alignment.changes.pop_back();
    ASSERT_TRUE(write_and_wait(*store, PutMerge{1, 9, {alignment}, std::nullopt, {}}));
  }
  const auto store = open(dir);
  const auto merge = store->merge();
  ASSERT_TRUE(merge);
  ASSERT_EQ(merge->alignments.size(), 1U);
  EXPECT_EQ(merge->alignments[0].state, AlignmentState::retracted);
  ASSERT_EQ(merge->alignments[0].changes.size(), 1U) << "those it had before are gone";
  const Change& change = merge->alignments[0].changes[0];
  EXPECT_EQ(change.kind, ChangeKind::filled);
  EXPECT_EQ(change.p_a, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(Eigen::Vector3d(change.length_m, change.width_m, change.height_m), Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(change.a_is_newer);
  EXPECT_EQ(std::pair(change.older_s, change.newer_s), std::pair(1.7e9, 1.8e9));
  EXPECT_EQ(merge->alignments[0].T_a_b.matrix(), alignment.T_a_b.matrix());
  EXPECT_EQ(merge->alignments[0].evidence.probability, 0.97);
  EXPECT_TRUE(std::isnan(merge->alignments[0].evidence.end_on_match));
  EXPECT_EQ(merge->atlas.revision, 4U);
  ASSERT_EQ(merge->atlas.components.size(), 1U);
  EXPECT_EQ(merge->atlas.components[0].placements[1].T_component_session.matrix(), alignment.T_a_b.matrix());
  EXPECT_EQ(store->sessions()->at(1).attempted_keyframes, 17U);
}

TEST_P(StoreContract, KeepsDecisionsAndThatTheyWereUndone) {
  const StoreHome dir(GetParam());
  DecisionRecord refusal{1, 7, Decision::refuse, pose_from_yaw(0.5, {1, 2, 3}), 5000, false};
  const DecisionRecord confirmation{2, 8, Decision::confirm, Pose::Identity(), 10, false};
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, std::nullopt, {refusal, confirmation}}));
    refusal.undone = true;
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, std::nullopt, {refusal}}));
  }
  const auto decisions = open(dir)->merge()->decisions;
  ASSERT_EQ(decisions.size(), 2U);
  EXPECT_TRUE(decisions[0].undone);
  EXPECT_EQ(decisions[0].decision, Decision::refuse);
  EXPECT_EQ(decisions[0].alignment, 7);
  EXPECT_EQ(decisions[0].T_a_b.matrix(), refusal.T_a_b.matrix());
  EXPECT_EQ(decisions[0].seen_points, 5000);
  EXPECT_FALSE(decisions[1].undone);
  EXPECT_EQ(decisions[1].decision, Decision::confirm);
}

Survey survey_of(SessionId session) {
  return {session,
          pose_from_yaw(0.5, {431250.123456789, 6212400.25, -3}),
          {{"P1", {1, 2, 3}, {431251.1, 6212402.2, 0}}, {"P \"2\"", {0.1, 0.2, 0.3}, {4, 5, 6}}}};
}

TEST_P(StoreContract, KeepsLabelsAnchorsAndSurveys) {
  const StoreHome dir(GetParam());
  const Survey first = survey_of(1), second{2, Pose::Identity(), {}};
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    ASSERT_TRUE(write_and_wait(*store, PutLabel{1, "north drift"}));
    ASSERT_TRUE(write_and_wait(*store, PutLabel{2, "gone"}));
    ASSERT_TRUE(write_and_wait(*store, PutLabel{2, ""}));
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "robot1")})) << "the robot comes again";
    for (const SessionId id : {2, 1, 7, 2}) ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, {}, {}, id}));
    for (const Survey& survey : {first, second, survey_of(3), first})
      ASSERT_TRUE(write_and_wait(*store, PutSurvey{survey}));
    ASSERT_TRUE(write_and_wait(*store, DropSurvey{3}));
  }
  const auto store = open(dir);
  const auto notes = store->notes();
  ASSERT_TRUE(notes) << notes.error().message;
  EXPECT_EQ(notes->labels, (std::map<SessionId, std::string>{{1, "north drift"}}));
  EXPECT_EQ(store->merge()->anchors, (std::vector<SessionId>{1, 7, 2})) << "in the order of their last choice";
  ASSERT_EQ(notes->surveys.size(), 2U);
  EXPECT_EQ(notes->surveys[0].session, 2);
  EXPECT_TRUE(notes->surveys[0].points.empty());
  const Survey& last = notes->surveys[1];
  EXPECT_EQ(last.session, 1);
  EXPECT_EQ(last.T_grid_session.matrix(), first.T_grid_session.matrix());
  ASSERT_EQ(last.points.size(), 2U);
  EXPECT_EQ(last.points[1].name, "P \"2\"");
  EXPECT_EQ(last.points[1].p_session_m, first.points[1].p_session_m);
  EXPECT_EQ(last.points[0].p_grid_m, first.points[0].p_grid_m);
}

TEST_P(StoreContract, KeepsTheRunnerUpsPlacement) {
  const StoreHome dir(GetParam());
  Alignment with{1, 1, 2, AlignmentState::candidate, Pose::Identity(), {}}, without = with;
  with.T_a_b_runner_up = pose_from_yaw(0.5, {1, 2, 3});
  without.id = 2, without.b = 3;
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2, 3})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {with, without}, {}, {}}));
  }
  const auto merge = open(dir)->merge();
  ASSERT_EQ(merge->alignments.size(), 2U);
  ASSERT_TRUE(merge->alignments[0].T_a_b_runner_up);
  EXPECT_EQ(merge->alignments[0].T_a_b_runner_up->matrix(), with.T_a_b_runner_up->matrix());
  EXPECT_FALSE(merge->alignments[1].T_a_b_runner_up);
}

}  // namespace
}  // namespace headframe
