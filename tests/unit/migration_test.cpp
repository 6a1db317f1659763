// From SQLite to PostgreSQL and back: all of it, or nothing that looks whole.
#include "server/store/migration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "server/store/postgres_schema.hpp"
#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

void no_progress(std::string_view, std::uint64_t, std::uint64_t) {}

class PostgresMigration : public testing::Test {
 protected:
  void SetUp() override {
    if (test::PostgresCluster::programs().empty()) GTEST_SKIP() << test::PostgresCluster::not_installed;
    postgres.emplace(Engine::postgres);
    fill(*open(sqlite));
  }

  /// A row or more of every table, with what is awkward in each.
  static void fill(Store& store) {
    for (const SessionId id : {1, 2, 3})
      ASSERT_TRUE(write_and_wait(store, PutSession{session_record(id, "robot \"ü\" " + std::to_string(id))}));
    for (std::uint64_t i = 1; i <= 30; ++i) {
      ASSERT_TRUE(write_and_wait(store, PutKeyframe{1, line_keyframe(i)}));
      ASSERT_TRUE(write_and_wait(store, PutCloud{{1, i}, std::string("\0cloud\xff", 7) + std::string(i * 100, 'x')}));
    }
    ASSERT_TRUE(write_and_wait(store, LetGo{{{1, 4}, {1, 5}}}));
    Alignment alignment{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
    alignment.evidence.end_on_match = std::numeric_limits<double>::quiet_NaN();
    alignment.changes = {{ChangeKind::filled, {1, 2, 3}, 4, 5, 6, true, 1.7e9, 1.8e9}};
    const Atlas atlas{1, {{1, {{1, Pose::Identity()}, {2, alignment.T_a_b}}}}};
    const DecisionRecord decision{1, 1, Decision::confirm, Pose::Identity(), 10, false};
    PutMerge merge{2, 17, {alignment}, atlas, {decision}, 1};
    merge.self_likeness = {{1, {120.5, 40, 2, 3.5, 4.5, {{{1, 2, 3}, {4, 5, 6}, 1, 0.5, 0.75, true}}, {{1, 7}}}}};
    const PoseConstraint place{{1, 7}, {2, 9}, pose_from_yaw(0.3, {1, 2, 3}), Matrix6d::Identity()};
    merge.closures = {{1, 2, std::make_shared<const std::vector<PoseConstraint>>(1, place)}};
    merge.frozen = {{2, 1, pose_from_yaw(0.1, {4, 5, 6}), {{1, Pose::Identity()}}}};
    merge.archived = PutArchived{3, true};
    merge.site = PutSite{1, "north"};
    merge.moved = MovedPoses{1, 1, {{3, pose_from_yaw(0.1, {3, 4, 5})}}};
    ASSERT_TRUE(write_and_wait(store, PutPoses{1, 2, {{1, {30, {{7, pose_from_yaw(0.2, {7, 8, 9})}}}}}}));
    ASSERT_TRUE(write_and_wait(store, merge));
    ASSERT_TRUE(write_and_wait(store, PutSessionNote{1, "two lines\nof \"text\""}));
    ASSERT_TRUE(write_and_wait(store, PutLabel{1, "north drift"}));
    ASSERT_TRUE(write_and_wait(store, PutRobotSite{"ant", "north"}));
    ASSERT_TRUE(write_and_wait(store, PutSurvey{{1, Pose::Identity(), {{"P 1", {1, 2, 3}, {4, 5, 6}}}}}));
    ASSERT_TRUE(write_and_wait(store, PutRobot{{"ant", std::string("\0digest\xff", 8), "", 12.5, 3, false, 64}}));
    ASSERT_TRUE(write_and_wait(store, PutTrouble{{3, 1, 2, "it died", false}}));
  }

  bool has_tables_in_postgres() const {
    PostgresDatabase database(postgres->url(), "PostgreSQL");
    EXPECT_TRUE(database.connect());
    return has_tables(database).value();
  }

  StoreHome sqlite{Engine::sqlite};
  std::optional<StoreHome> postgres;
};

TEST_F(PostgresMigration, TakesAllOfItThereAndBack) {
  const TableSums before = sum_tables(*sqlite.database(), no_progress).value();
  for (const auto& [table, sum] : before) EXPECT_GT(sum.rows, 0U) << table << ": this test has to fill every table";
  const auto there = migrate_to_postgres(sqlite.path(), postgres->url(), no_progress);
  ASSERT_TRUE(there) << there.error().message;
  EXPECT_EQ(there->tables, before.size());
  EXPECT_EQ(sum_tables(*postgres->database(), no_progress).value(), before);
  EXPECT_FALSE(std::filesystem::exists(sqlite.path() / "headframe.db"));
  const auto by_mistake = sqlite.try_open();
  ASSERT_FALSE(by_mistake);
  EXPECT_NE(by_mistake.error().message.find("was taken to PostgreSQL"), std::string::npos);
  {
    const auto store = open_postgres_store(sqlite.path(), postgres->url());
    ASSERT_TRUE(store) << store.error().message;
    EXPECT_EQ(keyframes(**store, 1).size(), 30U);
    EXPECT_EQ((*store)->load().damaged_keyframes, 0U);
    EXPECT_TRUE(std::isnan((*store)->merge()->alignments.at(0).evidence.end_on_match));
    const Alignment next{2, 1, 3, AlignmentState::candidate, Pose::Identity(), {}};
    EXPECT_TRUE(write_and_wait(**store, PutMerge{0, 0, {next}, {}, {}})) << "and it is written to";
    EXPECT_TRUE(write_and_wait(**store, PutKeyframe{1, line_keyframe(31)}));
  }
  const TableSums after = sum_tables(*postgres->database(), no_progress).value();
  const auto back = migrate_to_sqlite(postgres->url(), sqlite.path(), no_progress);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(sum_tables(*sqlite.database(), no_progress).value(), after);
  EXPECT_EQ(keyframes(*open(sqlite), 1).size(), 31U);
}

TEST_F(PostgresMigration, ReplacesNothing) {
  const StoreHome other(Engine::sqlite);
  fill(*open(other));
  ASSERT_TRUE(migrate_to_postgres(sqlite.path(), postgres->url(), no_progress));
  EXPECT_EQ(migrate_to_postgres(other.path(), postgres->url(), no_progress).error().code, ErrorCode::refused);
  EXPECT_TRUE(std::filesystem::exists(other.path() / "headframe.db"));
  EXPECT_EQ(migrate_to_sqlite(postgres->url(), other.path(), no_progress).error().code, ErrorCode::refused);
}

TEST_F(PostgresMigration, OfADatabaseThatIsInUseIsRefused) {
  {
    const auto store = open(sqlite);
    EXPECT_NE(migrate_to_postgres(sqlite.path(), postgres->url(), no_progress).error().message.find("in use"),
              std::string::npos);
  }
  const auto store = open(*postgres);
  EXPECT_EQ(migrate_to_postgres(sqlite.path(), postgres->url(), no_progress).error().code, ErrorCode::refused);
}

TEST_F(PostgresMigration, IntoTablesThatWereNeverUsedIsWelcome) {
  open(*postgres).reset();
  EXPECT_TRUE(migrate_to_postgres(sqlite.path(), postgres->url(), no_progress));
}

TEST_F(PostgresMigration, ThatFailsHalfwayLeavesBothAsTheyWere) {
  ASSERT_TRUE(sqlite.database()->execute("INSERT INTO robots VALUES (CAST(x'ff00' AS TEXT), x'', x'', 0, 0, 0, 0)"));
  const auto failed = migrate_to_postgres(sqlite.path(), postgres->url(), no_progress);
  ASSERT_FALSE(failed) << "no text of any encoding";
  EXPECT_EQ(failed.error().message.find('\n'), std::string::npos);
  EXPECT_FALSE(has_tables_in_postgres());
  EXPECT_TRUE(open(sqlite));
}

/// A table or column that is added to the schema and not to what is copied would be lost.
TEST_F(PostgresMigration, KnowsEveryColumnThatThereIs) {
  open(*postgres).reset();
  std::map<std::string, std::size_t> known, in_sqlite, in_postgres;
  for (const StoreTable& table : store_tables()) known[std::string(table.name)] = column_names(table).size();
  ASSERT_TRUE(sqlite.database()->each(
      "SELECT m.name, count(*) FROM sqlite_master m, pragma_table_info(m.name) WHERE m.type='table' AND m.name NOT LIKE"
      " 'sqlite_%' GROUP BY m.name",
      [&](const Row& row) { in_sqlite[row.text(0)] = static_cast<std::size_t>(row.integer(1)); }));
  ASSERT_TRUE(postgres->database()->each(
      "SELECT table_name::text, count(*) FROM information_schema.columns WHERE table_schema='headframe' AND table_name"
      " NOT IN ('writer', 'schema_version', 'servers', 'pair_work') GROUP BY table_name",
      [&](const Row& row) { in_postgres[row.text(0)] = static_cast<std::size_t>(row.integer(1)); }));
  EXPECT_EQ(in_sqlite, known);
  EXPECT_EQ(in_postgres, known);
}

}  // namespace
}  // namespace headframe
