// Databases that older servers wrote.
#include <gtest/gtest.h>

#include "server/store/schema.hpp"
#include "server/store/sqlite.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

/// What takes a database back to the schema before labels, anchors, surveys and rates.
constexpr const char* to_schema_3 =
    "ALTER TABLE sessions DROP COLUMN label; ALTER TABLE alignments DROP COLUMN T_a_b_runner_up;"
    "DROP TABLE anchors; DROP TABLE surveys; DROP TABLE survey_points; DROP TABLE troubles; ALTER TABLE robots DROP "
    "COLUMN rate_kib_s; ALTER TABLE keyframes DROP COLUMN checksum; DROP TABLE placed; DROP TABLE self_likeness; "
    "ALTER TABLE sessions DROP COLUMN attempted_whole;"
    "DROP TABLE loop_closures;"
    "DROP TABLE changes;"
    "ALTER TABLE sessions DROP COLUMN note; ALTER TABLE sessions DROP COLUMN archived; DROP TABLE frozen; DROP TABLE "
    "let_go; ALTER TABLE sessions DROP COLUMN site; DROP TABLE robot_sites;"
    "DROP TABLE moved_poses; DROP TABLE pose_updates; ALTER TABLE sessions DROP COLUMN pose_update;"
    "PRAGMA user_version=3;";

TEST(SqliteHistory, ADatabaseFromBeforeLabelsAndSurveysIsBroughtUp) {
  const TempDir dir;
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    const Alignment alignment{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {alignment}, {}, {}}));
    ASSERT_TRUE(write_and_wait(*store, CompleteSession{1}));
  }
  {
    auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
    ASSERT_TRUE(database);
    const auto back = database->execute(std::string(to_schema_3) +
                                        "INSERT INTO revisions VALUES (4, 0), (5, 0);"
                                        "INSERT INTO placements VALUES (4, 1, 1, x''), (5, 1, 2, x''), (5, 2, 2, x'')");
    ASSERT_TRUE(back) << back.error().message;
  }
  const auto store = open(dir);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->sessions()->size(), 2U);
  const auto merge = store->merge();
  ASSERT_EQ(merge->alignments.size(), 1U);
  EXPECT_EQ(merge->alignments[0].state, AlignmentState::published);
  EXPECT_FALSE(merge->alignments[0].T_a_b_runner_up);
  EXPECT_TRUE(merge->anchors.empty());
  EXPECT_EQ(merge->atlas.revision, 5U);
  ASSERT_EQ(merge->atlas.components.size(), 1U) << "the last revision, whole";
  EXPECT_EQ(merge->atlas.components[0].id, 2);
  EXPECT_EQ(merge->atlas.components[0].placements.size(), 2U);
  EXPECT_TRUE(store->notes()->labels.empty());
  EXPECT_TRUE(store->notes()->notes.empty());
  EXPECT_TRUE(merge->frozen.empty());
  EXPECT_FALSE(store->sessions()->at(0).archived);
  EXPECT_TRUE(store->sessions()->at(0).attempted_whole) << "what had ended is not tried again";
  EXPECT_FALSE(store->sessions()->at(1).attempted_whole);
  EXPECT_TRUE(store->sessions()->at(0).site.empty());
  EXPECT_TRUE(store->robot_sites()->empty());
  EXPECT_EQ(store->sessions()->at(0).pose_update, 0U);
  EXPECT_EQ(store->new_poses(1)->number, 0U);
  ASSERT_TRUE(write_and_wait(*store, PutLabel{1, "north"})) << "and it is written to";
  ASSERT_TRUE(write_and_wait(*store, PutSurvey{{1, Pose::Identity(), {}}}));
}

TEST(SqliteHistory, WhatCountedAsLookAlikesCountsAsSimilarPlaces) {
  const TempDir dir;
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    Alignment alignment{1, 1, 2, AlignmentState::candidate, Pose::Identity(), {}};
    alignment.evidence.look_alikes = 3;
    PutMerge merge{0, 0, {alignment}, {}, {}};
    merge.self_likeness = {{1, {100, 9, 0, 2, 0, {}, {}}}};
    ASSERT_TRUE(write_and_wait(*store, merge));
  }
  {
    auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
    ASSERT_TRUE(database);
    ASSERT_TRUE(
        database->execute("ALTER TABLE self_likeness DROP COLUMN similar_places;"
                          "ALTER TABLE self_likeness DROP COLUMN places;"
                          "DELETE FROM evidence WHERE name = 'similar_places';"
                          "PRAGMA user_version=" +
                          std::to_string(schema_version() - 2)));
  }
  const auto merge = open(dir)->merge();
  EXPECT_EQ(merge->alignments.at(0).evidence.similar_places, 3);
  EXPECT_EQ(merge->self_likeness.at(1).similar_places, 2);
}

TEST(SqliteHistory, ADatabaseFromBeforeDecisionsIsBroughtUp) {
  const TempDir dir;
  {
    auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
    ASSERT_TRUE(database && migrate(*database));
    ASSERT_TRUE(database->execute(std::string(to_schema_3) +
                                  "DROP TABLE decisions; ALTER TABLE alignments DROP COLUMN verdict;"
                                  "DROP TABLE robots; ALTER TABLE sessions DROP COLUMN spool_run;"
                                  "PRAGMA foreign_keys=OFF; PRAGMA user_version=1;"
                                  "INSERT INTO alignments VALUES (1, 2, 1, 'published', x''),"
                                  "(1, 3, 2, 'rejected', x''), (2, 3, 3, 'retracted', x'')"));
  }
  const auto merge = open(dir)->merge();
  ASSERT_TRUE(merge);
  ASSERT_EQ(merge->alignments.size(), 3U);
  EXPECT_EQ(merge->alignments[0].verdict, AlignmentState::verified);
  EXPECT_EQ(merge->alignments[1].verdict, AlignmentState::rejected);
  EXPECT_EQ(merge->alignments[2].verdict, AlignmentState::candidate);
  EXPECT_TRUE(merge->decisions.empty());
}

}  // namespace
}  // namespace headframe
