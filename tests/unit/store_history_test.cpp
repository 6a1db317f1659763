// Databases that older servers wrote, and what of an atlas is written when it changes.
#include <gtest/gtest.h>

#include "server/store/schema.hpp"
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
    "PRAGMA user_version=3;";

struct StoredAtlas : testing::Test {
  void SetUp() override {
    const auto store = open(dir);
    for (const SessionId id : {1, 2, 3})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
  }

  /// Sessions of the component of 1, each this far east of it.
  static Atlas atlas(std::uint64_t revision, const std::map<SessionId, double>& east_m) {
    Atlas out{revision, {{1, {}}}};
    for (const auto& [id, x_m] : east_m) out.components[0].placements.push_back({id, pose_from_yaw(0, {x_m, 0, 0})});
    return out;
  }

  int rows_of(std::uint64_t revision) const {
    auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
    int rows = 0;
    EXPECT_TRUE(database->each(
        "SELECT count(*) FROM placements WHERE revision=?",
        [&](const Row& row) { rows = static_cast<int>(row.integer(0)); }, revision));
    return rows;
  }

  TempDir dir;
};

TEST_F(StoredAtlas, ARevisionWritesWhatItMovesAndTheLastOneIsReadWhole) {
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(1, {{1, 0}, {2, 5}, {3, 9}}), {}}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(2, {{1, 0}, {2, 5}, {3, 10}}), {}}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(3, {{1, 0}, {3, 10}}), {}}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(4, {{1, 0}, {3, 10}}), {}}));
  }
  const Atlas read = open(dir)->merge()->atlas;
  EXPECT_EQ(read.revision, 4U);
  ASSERT_EQ(read.components.size(), 1U);
  ASSERT_EQ(read.components[0].placements.size(), 2U) << "2 was set aside";
  EXPECT_EQ(read.components[0].placements[1].session, 3);
  EXPECT_EQ(read.components[0].placements[1].T_component_session.translation().x(), 10);
  EXPECT_EQ(rows_of(1), 3);
  EXPECT_EQ(rows_of(2), 1);
  EXPECT_EQ(rows_of(3), 1) << "that it is gone";
  EXPECT_EQ(rows_of(4), 0);
}

TEST_F(StoredAtlas, KeepsHowSessionsLookLikeThemselvesUntilTheyAreDeleted) {
  const SelfLikeness one{120.5, 40, 2, 3.5, {{1, 7}, {1, 9}}}, other{30, 4, 0, 0, {}}, later{35, 5, 1, 0, {}};
  {
    const auto store = open(dir);
    PutMerge merge;
    merge.self_likeness = {{1, one}, {2, other}};
    ASSERT_TRUE(write_and_wait(*store, merge));
    merge.self_likeness = {{2, later}};
    ASSERT_TRUE(write_and_wait(*store, merge));
  }
  const auto store = open(dir);
  EXPECT_EQ(store->merge()->self_likeness, (std::map<SessionId, SelfLikeness>{{1, one}, {2, later}}));
  ASSERT_TRUE(write_and_wait(*store, PutTrouble{{1, 0, 0, "deleted", true}}));
  EXPECT_EQ(store->merge()->self_likeness, (std::map<SessionId, SelfLikeness>{{2, later}}));
}

TEST(Store, ADatabaseFromBeforeLabelsAndSurveysIsBroughtUp) {
  const TempDir dir;
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    const Alignment alignment{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {alignment}, {}, {}}));
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
  ASSERT_TRUE(write_and_wait(*store, PutLabel{1, "north"})) << "and it is written to";
  ASSERT_TRUE(write_and_wait(*store, PutSurvey{{1, Pose::Identity(), {}}}));
}

TEST(Store, ADatabaseFromBeforeDecisionsIsBroughtUp) {
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
