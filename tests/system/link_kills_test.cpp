// The real programs, killed without warning; and that the comparison would notice.
#include <gtest/gtest.h>

#include "server/map_merge_server.hpp"
#include "server/store/sqlite.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/kills.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/postgres_cluster.hpp"

namespace headframe::bench {
namespace {

TEST(LinkKills, TwentyKillsLoseDuplicateAndCorruptNothing) {
  const test::ScratchFolder scratch;
  KillPlan plan;
  plan.count = 20;
  plan.seed = 7;
  plan.keyframes = 400;
  const auto outcome = kill_campaign(plan, scratch.path());
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_GE(outcome->kills, plan.count);
  EXPECT_GT(outcome->server_kills, 0);
  EXPECT_LT(outcome->server_kills, outcome->kills);
  EXPECT_EQ(outcome->faults.sum(), 0U) << outcome->faults.first;
  EXPECT_EQ(outcome->faults.keyframes, 3 * plan.keyframes);
  EXPECT_EQ(outcome->faults.clouds, 3 * plan.keyframes);
}

TEST(LinkKills, OverPostgresqlTheyLoseDuplicateAndCorruptNothingEither) {
  if (test::PostgresCluster::programs().empty()) GTEST_SKIP() << test::PostgresCluster::not_installed;
  const auto cluster = test::PostgresCluster::make();
  ASSERT_TRUE(cluster) << cluster.error().message;
  const test::ScratchFolder scratch;
  KillPlan plan;
  plan.count = plan.kills_a_block = 8;
  plan.seed = 3;
  plan.keyframes = 150;
  plan.postgres = {[&] { return (*cluster)->make_database(); }, [&] { (*cluster)->kill(); },
                   [&] { return (*cluster)->start(); }};
  const auto outcome = kill_campaign(plan, scratch.path());
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_GT(outcome->server_kills, 0);
  EXPECT_GT(outcome->database_kills, 0);
  EXPECT_EQ(outcome->faults.sum(), 0U) << outcome->faults.first;
  EXPECT_EQ(outcome->faults.keyframes, 3 * plan.keyframes);
  EXPECT_EQ(outcome->faults.clouds, 3 * plan.keyframes);
}

class Audit : public testing::Test {
 protected:
  static constexpr std::uint64_t keyframes = 5;

  void SetUp() override {
    auto server = MapMergeServer::start({data(), {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}, true});
    ASSERT_TRUE(server) << server.error().message;
    const auto robot = RobotClient::open(drive_config("ant", spool(), "127.0.0.1", (*server)->robots().port));
    ASSERT_TRUE(robot) << robot.error().message;
    for (std::uint64_t i = 1; i <= keyframes; ++i) ASSERT_TRUE(add_drive_keyframe(**robot, "ant", i).value());
    ASSERT_TRUE((*robot)->finish(std::chrono::seconds(30)));
  }

  Faults compared_after(const std::string& tampering) {
    EXPECT_TRUE(SqliteDatabase::open((data() / "headframe.db").string())->execute(tampering));
    auto produced = produce("ant", keyframes, scratch.path() / "oracle");
    EXPECT_TRUE(produced);
    const auto known = told("ant", spool());
    EXPECT_TRUE(known);
    const auto faults = audit(data(), {{"ant", *produced}}, {{"ant", *known}});
    EXPECT_TRUE(faults);
    return faults.value_or(Faults());
  }

  std::filesystem::path data() const { return scratch.path() / "data"; }
  std::filesystem::path spool() const { return scratch.path() / "spool"; }
  test::ScratchFolder scratch;
};

TEST_F(Audit, FindsNothingWhereNothingIsWrong) {
  const Faults faults = compared_after("");
  EXPECT_EQ(faults.sum(), 0U) << faults.first;
  EXPECT_EQ(faults.keyframes, keyframes);
  EXPECT_EQ(faults.clouds, keyframes);
}

TEST_F(Audit, FindsAnAcknowledgedKeyframeThatIsGone) {
  EXPECT_EQ(compared_after("DELETE FROM keyframes WHERE sequence=5").lost, 1U);
}

TEST_F(Audit, FindsAnAcknowledgedCloudThatIsGone) {
  EXPECT_EQ(compared_after("DELETE FROM clouds WHERE sequence=2").clouds_lost, 1U);
}

TEST_F(Audit, FindsChangedContent) {
  const Faults faults = compared_after(
      "UPDATE keyframes SET stamp_s=stamp_s+1 WHERE sequence=3; UPDATE clouds SET encoded=x'00' WHERE sequence=4");
  EXPECT_EQ(faults.corrupted, 1U);
  EXPECT_EQ(faults.clouds_corrupted, 1U);
}

TEST_F(Audit, FindsASecondSession) {
  const Faults faults = compared_after(
      "INSERT INTO sessions (id, robot, session, sensor_model, beams, fov_up_deg, fov_down_deg, max_range_m, family, "
      "family_version, q_size, w_size, spool_id, complete, attempted_keyframes) SELECT id+1, robot, 'again', "
      "sensor_model, beams, fov_up_deg, fov_down_deg, max_range_m, "
      "family, family_version, q_size, w_size, spool_id, complete, attempted_keyframes FROM sessions");
  EXPECT_EQ(faults.duplicated, 1U);
}

}  // namespace
}  // namespace headframe::bench
