// What of an atlas is written when it changes, over both databases.
#include <gtest/gtest.h>

#include <optional>

#include "server/store/columns.hpp"
#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

class StoredAtlas : public OverBothStores {
 protected:
  void SetUp() override {
    OverBothStores::SetUp();
    if (IsSkipped()) return;
    home.emplace(GetParam());
    const StoreHome& dir = *home;
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
    const auto database = home->database();
    int rows = 0;
    EXPECT_TRUE(database->each(
        "SELECT count(*) FROM placements WHERE revision=?",
        [&](const Row& row) { rows = static_cast<int>(row.integer(0)); }, revision));
    return rows;
  }

  std::optional<StoreHome> home;
};

OVER_BOTH_STORES(StoredAtlas);

TEST_P(StoredAtlas, ARevisionWritesWhatItMovesAndTheLastOneIsReadWhole) {
  {
    const auto store = open(*home);
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(1, {{1, 0}, {2, 5}, {3, 9}}), {}}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(2, {{1, 0}, {2, 5}, {3, 10}}), {}}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(3, {{1, 0}, {3, 10}}), {}}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, atlas(4, {{1, 0}, {3, 10}}), {}}));
  }
  const Atlas read = open(*home)->merge()->atlas;
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

TEST(LikePlacesBlob, CutShortSaysThatItIsNotKnownWhereTheyAre) {
  const std::string whole = like_places_blob({{{1, 2, 3}, {4, 5, 6}, 1, 0.5, 0.75, true}, {}});
  EXPECT_EQ(like_places_from_blob(whole).size(), 2U);
  EXPECT_TRUE(like_places_from_blob(whole.substr(0, whole.size() - 1)).empty());
}

TEST_P(StoredAtlas, KeepsHowSessionsLookLikeThemselvesUntilTheyAreDeleted) {
  const SelfLikeness one{120.5, 40, 2, 3.5, 4.5, {{{1, 2, 3}, {4, 5, 6}, 1, 0.5, 0.75, true}, {}}, {{1, 7}, {1, 9}}},
      other{30, 4, 0, 0, 0, {}, {}}, later{35, 5, 1, 0, 0.5, {}, {}};
  {
    const auto store = open(*home);
    PutMerge merge;
    merge.self_likeness = {{1, one}, {2, other}};
    ASSERT_TRUE(write_and_wait(*store, merge));
    merge.self_likeness = {{2, later}};
    ASSERT_TRUE(write_and_wait(*store, merge));
  }
  const auto store = open(*home);
  EXPECT_EQ(store->merge()->self_likeness, (std::map<SessionId, SelfLikeness>{{1, one}, {2, later}}));
  ASSERT_TRUE(write_and_wait(*store, PutTrouble{{1, 0, 0, "deleted", true}}));
  EXPECT_EQ(store->merge()->self_likeness, (std::map<SessionId, SelfLikeness>{{2, later}}));
}

TEST_P(StoredAtlas, KeepsWhatIsFrozenArchivedAndNoted) {
  const FrozenSession one{
      1, 1, pose_from_yaw(0.3, {1, 2, 3}), {{1, Pose::Identity()}, {9, pose_from_yaw(-2, {4, 5, 6})}}};
  const FrozenSession other{2, 1, Pose::Identity(), {}};
  {
    const auto store = open(*home);
    PutMerge write;
    write.frozen = {other, {1, 7, Pose::Identity(), {}}};
    write.archived = PutArchived{3, true};
    ASSERT_TRUE(write_and_wait(*store, write));
    write.frozen = {one};
    write.archived = PutArchived{2, true};
    ASSERT_TRUE(write_and_wait(*store, write));
    write = {};
    write.archived = PutArchived{3, false};
    ASSERT_TRUE(write_and_wait(*store, write));
    ASSERT_TRUE(write_and_wait(*store, PutSessionNote{1, "the old shaft\nis flooded"}));
    ASSERT_TRUE(write_and_wait(*store, PutSessionNote{2, "gone"}));
    ASSERT_TRUE(write_and_wait(*store, PutSessionNote{2, ""}));
  }
  const auto store = open(*home);
  auto frozen = store->merge()->frozen;
  ASSERT_EQ(frozen.size(), 2U);
  EXPECT_EQ(frozen[0].frame, 1);
  EXPECT_EQ(frozen[0].T_frame_session.matrix(), one.T_frame_session.matrix());
  ASSERT_EQ(frozen[0].places.size(), 2U);
  EXPECT_EQ(frozen[0].places[1].sequence, 9U);
  EXPECT_EQ(frozen[0].places[1].T_component_session.matrix(), one.places[1].T_component_session.matrix());
  EXPECT_TRUE(frozen[1].places.empty());
  const auto sessions = store->sessions();
  EXPECT_TRUE(!sessions->at(0).archived && sessions->at(1).archived && !sessions->at(2).archived);
  EXPECT_EQ(store->notes()->notes, (std::map<SessionId, std::string>{{1, "the old shaft\nis flooded"}}));
  PutMerge thawed;
  thawed.thawed = 1;
  thawed.trouble = PutTrouble{{2, 0, 0, "deleted", true}};
  ASSERT_TRUE(write_and_wait(*store, thawed));
  EXPECT_TRUE(store->merge()->frozen.empty()) << "one is thawed, the other deleted";
}

TEST_P(StoredAtlas, KeepsSites) {
  {
    const auto store = open(*home);
    SessionRecord record = session_record(4, "fox");
    record.site = "north";
    ASSERT_TRUE(write_and_wait(*store, PutSession{record}));
    PutMerge write;
    write.site = PutSite{2, "south"};
    ASSERT_TRUE(write_and_wait(*store, write));
    for (const PutRobotSite& site : {PutRobotSite{"ant", "north"}, {"ant", "south"}, {"bee", "north"}, {"bee", ""}})
      ASSERT_TRUE(write_and_wait(*store, site));
  }
  const auto store = open(*home);
  const auto sessions = store->sessions();
  EXPECT_EQ(sessions->at(0).site, "");
  EXPECT_EQ(sessions->at(1).site, "south");
  EXPECT_EQ(sessions->at(3).site, "north");
  EXPECT_EQ(store->robot_sites().value(), (std::map<std::string, std::string>{{"ant", "south"}}));
}

TEST_P(StoredAtlas, KeepsLoopClosures) {
  PoseConstraint one{{1, 7}, {2, 9}, pose_from_yaw(0.3, {1, 2, 3}), Matrix6d::Random()};
  one.information = (one.information * one.information.transpose()).eval();
  const PoseConstraint other{{1, 70}, {1, 3}, pose_from_yaw(-2, {0.1, 0.2, -3}), Matrix6d::Identity()};
  {
    const auto store = open(*home);
    const auto found = [&](SessionId a, SessionId b, std::vector<PoseConstraint> places) {
      PutMerge write;
      write.closures = {{a, b, std::make_shared<const std::vector<PoseConstraint>>(std::move(places))}};
      return write_and_wait(*store, write);
    };
    ASSERT_TRUE(found(1, 2, {one, one}) && found(1, 1, {other}) && found(2, 2, {one}) && found(1, 1, {other, one}));
    ASSERT_TRUE(write_and_wait(*store, PutTrouble{{2, 0, 0, "asked", true}}));
  }
  const auto merge = open(*home)->merge();
  ASSERT_EQ(merge->closures.size(), 1U) << "those of a session that was deleted are gone";
  EXPECT_EQ(merge->closures[0].b, 1);
  EXPECT_EQ(*merge->closures[0].places, (std::vector{other, one})) << "the latest";
}

}  // namespace
}  // namespace headframe
