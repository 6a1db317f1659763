// Which clouds may go so that others find room, on both sides of each limit; and that they go when room is short.
#include "server/station/cloud_keeping.hpp"

#include "common/descriptor/wall_profile.hpp"
#include "server/station/room_watch.hpp"
#include "server/surroundings/seen_rock.hpp"
#include "tests/support/fake_station.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

constexpr std::size_t all_around = WallProfile::sectors;

/// Walls 4 m off, in so many directions from ahead on to the left.
WallProfile walls(std::size_t directions) {
  WallProfile profile;
  for (std::size_t i = 0; i < directions; ++i) profile.code[i] = encode_wall_range(4);
  return profile;
}

/// Sessions that have ended and drove along one line, in one map.
class CloudKeeping : public testing::Test {
 protected:
  void drive(SessionId id, std::size_t directions = all_around, const Eigen::Vector3d& at_m = {0, 0, 0},
             std::uint64_t clouds = 5) {
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    for (std::uint64_t i = 1; i <= 5; ++i) {
      Keyframe k = line_keyframe(i, 10);
      k.walls = walls(directions);
      ASSERT_TRUE(write_and_wait(*store, PutKeyframe{id, k}));
      if (i > clouds) continue;
      ASSERT_TRUE(write_and_wait(*store, PutCloud{{id, i}, std::string(100, 'c')}));
    }
    SessionRow& row = known.rows.emplace_back();
    row.id = id;
    row.complete = true;
    if (known.atlas.components.empty()) known.atlas.components.push_back({id, {}});
    known.atlas.components.front().placements.push_back({id, pose_from_yaw(0, at_m)});
  }
  /// How many clouds of each session may go.
  std::map<SessionId, std::size_t> may_go() const {
    const auto found = covered_clouds(*store, known);
    EXPECT_TRUE(found) << found.error().message;
    std::map<SessionId, std::size_t> out;
    for (const CoveredClouds& of : *found) {
      out[of.session] = of.clouds.size();
      EXPECT_EQ(of.bytes, 100 * of.clouds.size());
    }
    return out;
  }
  using Goes = std::map<SessionId, std::size_t>;

  TempDir dir;
  std::unique_ptr<Store> store = open(dir, {.group_ms = 0});
  KeptSessions known;
};

TEST_F(CloudKeeping, OldCloudsMayGoWhereTheNewestSessionSawTheSameRock) {
  drive(1);
  EXPECT_EQ(may_go(), Goes{}) << "it is alone";
  drive(2);
  EXPECT_EQ(may_go(), (Goes{{1, 5}}));
  drive(3);
  EXPECT_EQ(may_go(), (Goes{{1, 5}, {2, 5}}));
  drive(4, all_around, {500, 0, 0});
  EXPECT_EQ(may_go(), (Goes{{1, 5}, {2, 5}})) << "it was elsewhere";
}

TEST_F(CloudKeeping, OnlyWhatStaysCovers) {
  drive(1);
  drive(2, all_around, {0, 0, 0}, 2);
  EXPECT_EQ(may_go(), (Goes{{1, 2}})) << "of the rest session 2 has no clouds";
  ASSERT_TRUE(write_and_wait(*store, LetGo{{{2, 1}}}));
  EXPECT_EQ(may_go(), (Goes{{1, 1}}));
}

TEST_F(CloudKeeping, NineTenthsOfTheWallsHaveToHaveBeenSeen) {
  drive(1);
  drive(2, 140);
  EXPECT_EQ(may_go(), Goes{});
  drive(3, 172);
  EXPECT_EQ(may_go(), (Goes{{1, 5}, {2, 5}}));
}

TEST_F(CloudKeeping, OfTooFewWallsNothingIsSaid) {
  drive(1, SeenRock::least_walls - 1);
  drive(2, SeenRock::least_walls);
  drive(3);
  EXPECT_EQ(may_go(), (Goes{{2, 5}}));
}

TEST_F(CloudKeeping, AnotherLevelIsOtherRock) {
  drive(1);
  drive(2, all_around, {0, 0, 6});
  EXPECT_EQ(may_go(), Goes{});
  drive(3, all_around, {0, 0, 1});
  EXPECT_EQ(may_go(), (Goes{{1, 5}}));
}

TEST_F(CloudKeeping, WhatIsFrozenArchivedSetAsideOrGrowsKeepsAll) {
  drive(1);
  drive(2);
  ASSERT_EQ(may_go(), (Goes{{1, 5}}));
  const SessionRow was = known.rows[0];
  for (const auto change :
       {+[](SessionRow& row) { row.frozen = true; }, +[](SessionRow& row) { row.archived = true; },
        +[](SessionRow& row) { row.why_aside = "loose"; }, +[](SessionRow& row) { row.complete = false; }}) {
    change(known.rows[0]);
    EXPECT_EQ(may_go(), Goes{});
    known.rows[0] = was;
    change(known.rows[1]);
    const Goes covered_by_what_is_frozen = known.rows[1].frozen ? Goes{{1, 5}} : Goes{};
    EXPECT_EQ(may_go(), covered_by_what_is_frozen);
    known.rows[1] = was;
    known.rows[1].id = 2;
  }
}

TEST_F(CloudKeeping, WhatIsTriedWithOneThatGrowsKeepsAll) {
  drive(1);
  drive(2);
  known.rows.emplace_back().id = 7;
  known.alignments.push_back({1, 1, 7, AlignmentState::rejected, Pose::Identity(), {}});
  EXPECT_EQ(may_go(), (Goes{{1, 5}}));
  known.alignments[0].state = AlignmentState::candidate;
  EXPECT_EQ(may_go(), Goes{});
  known.rows.back().complete = true;
  EXPECT_EQ(may_go(), (Goes{{1, 5}}));
}

TEST_F(CloudKeeping, TheOldestGoUntilThereIsRoom) {
  drive(1);
  drive(2);
  drive(3);
  const auto all = covered_clouds(*store, known).value();
  const auto taken = [&](std::uint64_t bytes) {
    std::size_t clouds = 0;
    for (const CoveredClouds& of : first_bytes(all, bytes)) clouds += of.clouds.size();
    return clouds;
  };
  EXPECT_EQ(taken(0), 0U);
  EXPECT_EQ(taken(100), 1U);
  EXPECT_EQ(taken(101), 2U);
  EXPECT_EQ(first_bytes(all, 500).size(), 1U);
  EXPECT_EQ(first_bytes(all, 501).size(), 2U);
  EXPECT_EQ(taken(1'000'000), 10U);
  std::vector<std::uint64_t> told;
  std::promise<Result<void>> done;
  let_go(*store, first_bytes(all, 300),
         {[&](SessionId, const auto& sequences) { told = sequences; }, [&](const auto& r) { done.set_value(r); }});
  ASSERT_TRUE(done.get_future().get());
  EXPECT_EQ(told, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(store->cloud_sequences(1).value(), (std::vector<std::uint64_t>{4, 5}));
}

TEST(RoomWatch, LetsCloudsGoWhenLessIsFreeThanThePolicyAsksFor) {
  FakeStation station;  // 1000 bytes of session 1 may go, and 500 of session 2
  RoomWatch watch(station);
  const auto went = [&] { return watch.look().value(); };
  station.free = 799;
  EXPECT_TRUE(went().empty()) << "keep = \"all\"";
  station.keep = {true, 800};
  station.free.reset();
  EXPECT_TRUE(went().empty()) << "nobody knows";
  station.free = 800;
  EXPECT_TRUE(went().empty());
  station.free = 799;
  const auto gone = went();  // until half as much again is free: 401 bytes
  ASSERT_EQ(gone.size(), 1U);
  EXPECT_EQ(gone[0].session, 1);
  EXPECT_EQ(gone[0].bytes, 600U);
  EXPECT_EQ(station.rows[0].let_go, 1U);
  station.covered.clear();
  EXPECT_TRUE(went().empty()) << "nothing may go: that is no fault";
}

}  // namespace
}  // namespace headframe
