// What a robot makes of pages: whole, moved, broken, and of whatever bytes.
#include "client/uplink/surroundings_book.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/convert.hpp"

namespace headframe {
namespace {

const Pose T_component_mine = pose_from_yaw(1.2, {100, -20, 3});

v1::SurroundingsPage page(std::uint64_t version, bool anew = false, bool more = false) {
  v1::SurroundingsPage out;
  out.set_epoch(77);
  out.set_version(version);
  out.set_anew(anew);
  out.set_more(more);
  out.set_revision(4);
  *out.mutable_anchor() = to_proto(SessionKey{"bee", "s1"});
  *out.mutable_t_component_session() = to_proto(T_component_mine);
  return out;
}

/// A path of session 2 from point `first` on, each 2 m further along x.
v1::ServerMessage path(std::uint64_t version, std::uint32_t first, int points, bool anew = false, bool more = false) {
  v1::ServerMessage message;
  auto& told = *message.mutable_trajectories();
  *told.mutable_page() = page(version, anew, more);
  if (first == 0) {
    auto& session = *told.add_sessions();
    session.set_number(2);
    session.set_age_s(30);
    *session.mutable_session() = to_proto(SessionKey{"bee", "s1"});
  }
  auto& part = *told.add_parts();
  part.set_session(2);
  part.set_first(first);
  for (int i = 0; i < points; ++i)
    for (const int step : {first == 0 && i == 0 ? 50 : 20, 0, 0}) part.add_steps(step);
  return message;
}

class Book : public testing::Test {
 protected:
  Book() {
    book.want_trajectories(true);
    book.want_coverage(true);
  }
  HeldVersion held() const {
    const auto question = book.trajectories_question().trajectories_request();
    return {question.epoch(), question.version()};
  }
  SurroundingsBook book;
};

TEST_F(Book, PagesMakeAPathInTheRobotsOwnFrame) {
  auto taken = book.take(path(3, 0, 4, true, true));
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->told.index(), 0U) << "more comes";
  EXPECT_EQ(taken->next->trajectories_request().version(), 3U);
  taken = book.take(path(5, 4, 2));
  ASSERT_TRUE(taken);
  const auto& told = std::get<Trajectories>(taken->told);
  ASSERT_EQ(told.paths.size(), 1U);
  ASSERT_EQ(told.paths[0].p_local_m.size(), 6U);
  EXPECT_EQ(told.paths[0].age_s, 30);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(
        (T_component_mine * told.paths[0].p_local_m[i] - Eigen::Vector3d(5 + 2.0 * static_cast<double>(i), 0, 0))
            .norm(),
        0, 1e-9);
}

TEST_F(Book, APathThatBeginsAnewTakesThePlaceOfTheOldAndOneThatIsGoneGoes) {
  ASSERT_TRUE(book.take(path(3, 0, 4, true)));
  auto taken = book.take(path(9, 0, 2));
  EXPECT_EQ(std::get<Trajectories>(taken->told).paths.at(0).p_local_m.size(), 2U);
  v1::ServerMessage gone = path(12, 0, 0);
  gone.mutable_trajectories()->mutable_parts(0)->set_gone(true);
  taken = book.take(gone);
  EXPECT_TRUE(std::get<Trajectories>(taken->told).paths.empty());
}

TEST_F(Book, WhatDoesNotFollowIsNotTakenAndAllIsAskedAnew) {
  ASSERT_TRUE(book.take(path(3, 0, 4, true)));
  EXPECT_EQ(held(), (HeldVersion{77, 3}));
  const auto taken = book.take(path(9, 5, 2));
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->told.index(), 0U);
  EXPECT_EQ(held(), HeldVersion{});
}

TEST_F(Book, WhatNoServerMaySendIsAFaultAndAllIsAskedAnew) {
  const auto faulty = [&](const std::function<void(v1::Trajectories&)>& change) {
    (void)book.take(path(3, 0, 4, true));
    v1::ServerMessage message = path(5, 4, 2);
    change(*message.mutable_trajectories());
    EXPECT_FALSE(book.take(message));
    EXPECT_EQ(held(), HeldVersion{});
  };
  faulty([](v1::Trajectories& t) { t.mutable_parts(0)->add_steps(1); });
  faulty([](v1::Trajectories& t) { t.mutable_page()->clear_t_component_session(); });
  faulty([](v1::Trajectories& t) { t.mutable_page()->mutable_anchor()->set_robot("a/b"); });
  faulty([](v1::Trajectories& t) { t.add_sessions()->set_age_s(NAN); });
  faulty([](v1::Trajectories& t) {
    for (int i = 0; i < 3; ++i) t.mutable_parts(0)->set_steps(i, std::numeric_limits<std::int32_t>::max());
  });
}

TEST(SmallBook, NoMorePointsAreHeldThanMayBe) {
  SurroundingsBook book(10);
  book.want_trajectories(true);
  EXPECT_TRUE(book.take(path(3, 0, 10, true)));
  EXPECT_FALSE(book.take(path(4, 10, 1)));
}

TEST_F(Book, TilesComeChangeAndGo) {
  CoverageTile tile;
  tile.cells[5] = {coverage_path, 9, 2};
  tile.seen_by[2] = 9;
  v1::ServerMessage message;
  auto& coverage = *message.mutable_coverage();
  *coverage.mutable_page() = page(3, true);
  coverage.set_cell_m(1);
  coverage.set_tile_cells(32);
  auto& told = *coverage.add_tiles();
  told.set_x(-1);
  told.set_cells(encode_tile(tile));
  auto taken = book.take(message);
  ASSERT_TRUE(taken) << taken.error().message;
  const auto& whole = std::get<Coverage>(taken->told);
  EXPECT_EQ(whole.at(T_component_mine.inverse() * Eigen::Vector3d(-26.5, 0.5, 0)).what, coverage_path);
  EXPECT_EQ(whole.at(T_component_mine.inverse() * Eigen::Vector3d(-27.5, 0.5, 0)).what, 0);
  coverage.mutable_page()->set_anew(false);
  told.clear_cells();
  taken = book.take(message);
  EXPECT_TRUE(std::get<Coverage>(taken->told).tiles.empty());
  told.set_cells("rubbish");
  EXPECT_FALSE(book.take(message));
  told.clear_cells();
  coverage.set_tile_cells(64);
  EXPECT_FALSE(book.take(message)) << "cells of another size";
}

TEST_F(Book, PartsOfAnotherMapAndThoseThatDoNotFollowArePassedOver) {
  book.want_map({SphereRegion{{0, 0, 0}, 5}});
  const std::string bytes = encode_cloud({{{{0, 0, 0}, {{1, 2, 3}, {2, 2, 3}}}}}).value();
  const auto part = [&](std::uint64_t id, std::size_t offset, std::size_t size) {
    v1::ServerMessage message;
    auto& p = *message.mutable_map_part();
    p.set_id(id);
    p.set_offset(static_cast<std::uint32_t>(offset));
    p.set_data(bytes.data() + offset, std::min(size, bytes.size() - offset));
    if (offset == 0) p.set_total_bytes(static_cast<std::uint32_t>(bytes.size()));
    return book.take(message);
  };
  EXPECT_EQ(part(9, 0, 10)->told.index(), 0U);
  EXPECT_FALSE(part(1, 10, 10)->next.has_value());
  EXPECT_EQ(part(1, 0, 10)->next->map_next().offset(), 10U);
  EXPECT_FALSE(part(1, 20, 10)->next.has_value());
  const auto whole = part(1, 10, bytes.size());
  ASSERT_TRUE(whole);
  EXPECT_EQ(std::get<MapAround>(whole->told).points.size(), 2U);
  EXPECT_FALSE(book.wants_map());
}

TEST_F(Book, AMapOfMoreBytesThanAnnouncedOrMayBeIsAFault) {
  v1::ServerMessage message;
  message.mutable_map_part()->set_id(1);
  message.mutable_map_part()->set_total_bytes(3);
  message.mutable_map_part()->set_data("1234");
  book.want_map({SphereRegion{{0, 0, 0}, 5}});
  EXPECT_FALSE(book.take(message));
  book.want_map({SphereRegion{{0, 0, 0}, 5}});
  message.mutable_map_part()->set_id(2);
  message.mutable_map_part()->set_total_bytes(16 * 1024 * 1024 + 1);
  EXPECT_FALSE(book.take(message));
}

}  // namespace
}  // namespace headframe
