// What is new of a component since a version: pages against the whole, moves, sessions that come and go.
#include "server/surroundings/component_map.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

constexpr std::size_t one_page = 1 << 24;

class MadeComponent : public testing::Test {
 protected:
  void drive(SessionId session, std::uint64_t keyframes, double step_m = 1) {
    auto& all = driven_[session];
    while (all.size() < keyframes) {
      all.push_back(line_keyframe(all.size() + 1, step_m));
      all.back().walls.code.fill(150);
    }
    durable_[session] = keyframes;
  }
  void place(SessionId session, const Eigen::Vector3d& at) {
    std::erase_if(component_.placements, [&](const Placement& p) { return p.session == session; });
    component_.placements.push_back({session, pose_from_yaw(0, at)});
  }
  void leave(SessionId session) {
    std::erase_if(component_.placements, [&](const Placement& p) { return p.session == session; });
  }
  void refresh() {
    const auto read = [&](SessionId session, std::uint64_t first, const std::function<void(Keyframe)>& visit) {
      for (std::uint64_t s = first; s <= driven_[session].size(); ++s) {
        ++read_;
        visit(driven_[session][s - 1]);
      }
      return Result<void>();
    };
    ASSERT_TRUE(map_.refresh(component_, durable_, read, [] { return false; }));
  }

  /// A robot that takes pages in as they come.
  struct Reader {
    std::uint64_t version = 0;
    std::map<SessionId, std::vector<PathPoint>> paths;
    std::map<TileIndex, std::string> tiles;
    std::set<SessionId> placed;
    std::size_t pages = 0, points = 0;
  };
  void take_paths(Reader& r, SessionId receiver, std::size_t page_bytes = one_page) const {
    while (const auto page = map_.paths_after(r.version, receiver, page_bytes)) {
      ++r.pages;
      ASSERT_GT(page->version, r.version);
      r.version = page->version;
      r.placed.insert(page->placed.begin(), page->placed.end());
      for (const auto& piece : page->paths) {
        auto& path = r.paths[piece.session];
        ASSERT_TRUE(r.placed.contains(piece.session) || piece.gone) << "its number was told before";
        if (piece.first == 0) path.clear();
        ASSERT_EQ(path.size(), piece.first);
        ASSERT_TRUE(piece.first == 0 || piece.last == path.back());
        path.insert(path.end(), piece.points.begin(), piece.points.end());
        r.points += piece.points.size();
        if (piece.gone) r.paths.erase(piece.session);
      }
      ASSERT_EQ(page->more, map_.paths_after(r.version, receiver, page_bytes).has_value());
    }
  }
  void take_coverage(Reader& r, std::size_t page_bytes = one_page) const {
    while (const auto page = map_.coverage_after(r.version, page_bytes)) {
      ++r.pages;
      r.version = page->version;
      for (const auto& [index, encoded] : page->tiles) r.tiles[index] = encoded;
    }
  }

  Component component_{1, {}};
  std::map<SessionId, std::uint64_t> durable_;
  std::map<SessionId, std::vector<Keyframe>> driven_;
  std::size_t read_ = 0;
  ComponentMap map_{1000};
};

TEST_F(MadeComponent, PagesOfAnySizeGiveWhatOneGives) {
  for (const SessionId session : {1, 2, 3}) {
    drive(session, 200);
    place(session, {0, 20.0 * static_cast<double>(session), 0});
  }
  refresh();
  Reader whole, small, coverage, tiles;
  take_paths(whole, 1);
  take_paths(small, 1, 100);
  EXPECT_EQ(whole.pages, 1U);
  EXPECT_GT(small.pages, 10U);
  EXPECT_EQ(whole.paths, small.paths);
  EXPECT_FALSE(whole.paths.contains(1)) << "its own";
  ASSERT_EQ(whole.paths.at(2).size(), 100U) << "a point for each 2 m";
  EXPECT_EQ(whole.paths.at(2).front(), (PathPoint{10, 405, -3}));
  take_coverage(coverage);
  take_coverage(tiles, 100);
  EXPECT_GT(tiles.pages, coverage.pages);
  EXPECT_EQ(coverage.tiles, tiles.tiles);
}

TEST_F(MadeComponent, AnUpdateHoldsWhatIsNewAndReadsNoMore) {
  for (const SessionId session : {1, 2}) {
    drive(session, 200);
    place(session, {0, 0, 0});
  }
  refresh();
  EXPECT_EQ(read_, 400U);
  Reader paths, coverage;
  take_paths(paths, 1);
  take_coverage(coverage);
  refresh();
  EXPECT_FALSE(map_.paths_after(paths.version, 1, one_page));
  EXPECT_FALSE(map_.coverage_after(coverage.version, one_page));
  drive(2, 220);
  refresh();
  EXPECT_EQ(read_, 420U);
  const auto page = map_.paths_after(paths.version, 1, one_page);
  ASSERT_TRUE(page);
  ASSERT_EQ(page->paths.size(), 1U);
  EXPECT_EQ(page->paths[0].first, 100U);
  EXPECT_EQ(page->paths[0].points.size(), 10U);
  const auto tiles = map_.coverage_after(coverage.version, one_page);
  ASSERT_TRUE(tiles);
  EXPECT_LT(tiles->tiles.size(), coverage.tiles.size() / 2);
  EXPECT_FALSE(map_.paths_after(paths.version, 2, one_page)) << "its own path is no news for it";
}

TEST_F(MadeComponent, ASessionThatWasSplitEndsWhereItsOdometryJumped) {
  for (const SessionId session : {1, 2}) {
    drive(session, 200);
    place(session, {0, 0, 0});
  }
  refresh();
  Reader paths, coverage;
  take_paths(paths, 1);
  take_coverage(coverage);
  const std::size_t before = paths.paths.at(2).size();
  driven_[2].resize(50);
  durable_[2] = 50;
  refresh();
  take_paths(paths, 1);
  take_coverage(coverage);
  EXPECT_LT(paths.paths.at(2).size(), before / 3);
  EXPECT_EQ(map_.keyframes(2)->size(), 50U);
  Reader fresh, fresh_coverage;
  take_paths(fresh, 1);
  take_coverage(fresh_coverage);
  EXPECT_EQ(paths.paths, fresh.paths);
  std::erase_if(coverage.tiles, [](const auto& tile) { return tile.second.empty(); });
  std::erase_if(fresh_coverage.tiles, [](const auto& tile) { return tile.second.empty(); });
  EXPECT_EQ(coverage.tiles, fresh_coverage.tiles);
}

TEST_F(MadeComponent, ASessionWhosePastWasMovedIsToldAnewWhereItLies) {
  for (const SessionId session : {1, 2}) {
    drive(session, 100);
    place(session, {0, 0, 0});
  }
  refresh();
  Reader paths, coverage;
  take_paths(paths, 1);
  take_coverage(coverage);
  const auto before = paths.paths.at(2);
  for (Keyframe& k : driven_[2]) k.T_local_sensor.translation().y() += 30;
  map_.moved(2, 0);
  refresh();
  take_paths(paths, 1);
  EXPECT_EQ(paths.paths.at(2), before) << "nobody said that it moved";
  map_.moved(2, 1);
  map_.moved(7, 1);  // of another component
  refresh();
  take_paths(paths, 1);
  take_coverage(coverage);
  ASSERT_EQ(paths.paths.at(2).size(), before.size());
  EXPECT_EQ(paths.paths.at(2)[5][1], before[5][1] + 300) << "in tenths of a metre";
  EXPECT_EQ(position(driven_[2][9]).y(), map_.keyframes(2)->at(9).T_local_sensor.translation().y());
  Reader fresh_coverage;
  take_coverage(fresh_coverage);
  std::erase_if(coverage.tiles, [](const auto& tile) { return tile.second.empty(); });
  std::erase_if(fresh_coverage.tiles, [](const auto& tile) { return tile.second.empty(); });
  EXPECT_EQ(coverage.tiles, fresh_coverage.tiles);
  const std::size_t read = read_;
  map_.moved(2, 1);
  refresh();
  EXPECT_EQ(read_, read) << "once";
}

TEST_F(MadeComponent, WhoMovedLittleIsNotToldAndWhoMovedMoreIsToldAnew) {
  for (const SessionId session : {1, 2}) {
    drive(session, 50);
    place(session, {0, 0, 0});
  }
  refresh();
  Reader r;
  take_paths(r, 1);
  place(2, {0, 0.24, 0});
  refresh();
  EXPECT_FALSE(map_.paths_after(r.version, 1, one_page));
  EXPECT_EQ(map_.redrawn(), 0U);
  place(2, {0, 0.26, 0});
  refresh();
  EXPECT_GT(map_.redrawn(), r.version);
  const std::size_t before = r.points;
  take_paths(r, 1);
  EXPECT_EQ(r.points - before, 25U);
  EXPECT_EQ(r.paths.at(2).front()[1], 8) << "0.5 + 0.26 m";
  Reader anew;
  take_paths(anew, 1);
  EXPECT_EQ(anew.paths, r.paths);
}

TEST_F(MadeComponent, WhoTurnsALittleMovesFarAtItsEnd) {
  for (const SessionId session : {1, 2}) drive(session, 100);
  place(1, {0, 0, 0});
  place(2, {0, 0, 0});
  refresh();
  component_.placements[1].T_component_session = pose_from_yaw(0.003, {0, 0, 0});  // 0.3 m at 100 m
  refresh();
  EXPECT_GT(map_.redrawn(), 0U);
}

TEST_F(MadeComponent, WhoLeavesIsGoneWithItsTilesAndMayComeBack) {
  for (const SessionId session : {1, 2}) drive(session, 40);
  place(1, {0, 0, 0});
  place(2, {0, 500, 0});
  refresh();
  Reader r, tiles;
  take_paths(r, 1);
  take_coverage(tiles);
  leave(2);
  refresh();
  take_paths(r, 1);
  EXPECT_TRUE(r.paths.empty());
  take_coverage(tiles);
  for (const auto& [index, encoded] : tiles.tiles) EXPECT_EQ(encoded.empty(), index.y > 4) << index.x << ' ' << index.y;
  EXPECT_EQ(map_.keyframes(2), nullptr);
  place(2, {0, 500, 0});
  refresh();
  take_paths(r, 1);
  EXPECT_EQ(r.paths.at(2).size(), 20U);
  take_coverage(tiles);
  Reader anew;
  take_coverage(anew);
  EXPECT_EQ(anew.tiles, tiles.tiles);
}

TEST_F(MadeComponent, CloudsThatCameSinceAVersionAreKnownByIt) {
  drive(1, 5);
  place(1, {0, 0, 0});
  refresh();
  map_.note_clouds(1, {1, 2});
  const auto then = map_.version();
  map_.note_clouds(1, {1, 2, 4});
  EXPECT_LE(map_.cloud_version(1, 2), then);
  EXPECT_GT(map_.cloud_version(1, 4), then);
  EXPECT_EQ(map_.cloud_version(1, 3), 0U);
}

}  // namespace
}  // namespace headframe
