// The place index over the whole database, on both sides of its switch from exact search to FLANN.
#include "server/merge/partner_ranking.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <set>

#include "common/descriptor/wall_profile.hpp"
#include "server/place/wall_signature.hpp"

namespace headframe {
namespace {

constexpr std::size_t switches_at = 20000;  // keyframes of a family, from exact search to FLANN

const FamilyId family{"any", 1};

/// Sessions of keyframes whose q lie around a place of their own.
struct Database {
  SessionMap sessions{MergeConfig{}};
  PartnerRanking ranking{MergeConfig{}, switches_at};
  std::mt19937 rng{1};
  std::size_t size = 0;

  void add(SessionId id, std::size_t keyframes, float around) {
    if (!sessions.contains(id)) sessions.add(id, family);
    std::normal_distribution<float> spread(around, 1.0F);
    for (std::size_t i = 0; i < keyframes; ++i, ++size) {
      Keyframe k;
      k.sequence = sessions.at(id).keyframes.size() + 1;
      k.stamp_s = static_cast<double>(k.sequence);
      k.T_local_sensor.translation().x() = static_cast<double>(k.sequence);
      for (int n = 0; n < 8; ++n) k.descriptor.q.push_back(spread(rng));
      ranking.add(id, sessions.add_keyframe(id, std::move(k)), sessions);
    }
  }
  void take_to(const std::string& site, const std::vector<SessionId>& moved) {
    for (const SessionId id : moved) {
      sessions.set_site(id, site);
      ranking.take_to_site(id, sessions);
    }
  }
  std::vector<SessionId> rank(SessionId id) { return ranking.rank(id, sessions); }
};

TEST(PartnerRanking, NearSessionsComeFirstBelowAndAboveTheSwitchToFlann) {
  Database database;
  database.add(1, 40, 0);
  database.add(2, 10000, 30);
  database.add(3, 60, 0.5F);
  database.add(4, 60, 90);
  const std::vector<SessionId> expected{3, 2, 4};  // of those that nothing speaks for the earlier
  EXPECT_EQ(database.rank(1), expected);
  database.add(2, switches_at - database.size, 30);
  EXPECT_EQ(database.rank(1), expected) << "exact";
  database.add(4, 1, 90);
  EXPECT_EQ(database.size, switches_at + 1);
  EXPECT_EQ(database.rank(1), expected) << "by FLANN";
  EXPECT_EQ(database.rank(4).front(), 2) << "the nearest after itself";
  database.add(5, 60, 89);
  EXPECT_EQ(database.rank(4).front(), 5) << "what came after the switch is found";
}

TEST(PartnerRanking, OnlyThoseOfItsSiteAreWorthASearch) {
  Database database;
  for (const SessionId id : {1, 2, 3, 4}) database.add(id, 40, static_cast<float>(id));
  database.take_to("south", {3, 4});
  EXPECT_EQ(database.rank(1), std::vector<SessionId>{2});
  EXPECT_EQ(database.rank(3), std::vector<SessionId>{4});
  database.add(3, 20, 3);
  database.take_to("south", {1});
  EXPECT_TRUE(database.rank(2).empty());
  EXPECT_EQ(database.rank(4), (std::vector<SessionId>{3, 1})) << "the nearest first, by what it brought along";
  EXPECT_TRUE(database.rank(2).empty());
  database.take_to("", {3});
  EXPECT_EQ(database.rank(2), std::vector<SessionId>{3}) << "back, with what came meanwhile";
}

TEST(PartnerRanking, OtherFamiliesComeLast) {
  Database database;
  database.add(1, 5, 0);
  database.add(2, 5, 0);
  database.add(4, 5, 0);
  EXPECT_EQ(database.rank(1), (std::vector<SessionId>{2, 4}));
  database.sessions.add(3, {"other", 1});
  EXPECT_EQ(database.rank(1), (std::vector<SessionId>{2, 4, 3}));
}

/// A keyframe of a straight tunnel of this width, as the sensor sees its walls when it faces this way.
Keyframe tunnel(double width_m, double yaw_rad, std::uint64_t sequence) {
  Keyframe k;
  k.sequence = sequence;
  k.stamp_s = k.T_local_sensor.translation().x() = static_cast<double>(sequence);
  for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
    const double azimuth_rad = (2 * static_cast<double>(i) + 1) * std::numbers::pi / 180 + yaw_rad;
    k.walls.code[i] = encode_wall_range(
        static_cast<float>(std::min(60.0, width_m / 2 / std::max(1e-3, std::abs(std::sin(azimuth_rad))))));
  }
  return k;
}

/// Sessions of `families` families in turn, each of one tunnel, the wider the higher its id.
struct Tunnels {
  explicit Tunnels(int count, int families) {
    for (SessionId id = 1; id <= count; ++id) {
      sessions.add(id, {"family " + std::to_string(id % families), 1});
      for (std::uint64_t i = 1; i <= 3; ++i) {
        Keyframe k = tunnel(3 + 0.25 * static_cast<double>(id), 0.7 * static_cast<double>(id), i);
        k.descriptor.q = {static_cast<float>(id), 1};
        ranking.add(id, sessions.add_keyframe(id, std::move(k)), sessions);
      }
    }
  }
  MergeConfig config = [] {
    MergeConfig c;
    c.partners = 1;
    return c;
  }();
  SessionMap sessions{config};
  PartnerRanking ranking{config};
};

TEST(PartnerRanking, AllAreTriedUpToTheLimitAndTheMostAlikeBeyond) {
  Tunnels few(2, 1), many(40, 1);
  EXPECT_EQ(few.ranking.rank(1, few.sessions).size(), 1U);
  const auto chosen = many.ranking.rank(20, many.sessions);
  EXPECT_EQ(std::set<SessionId>(chosen.begin(), chosen.end()), (std::set<SessionId>{18, 19, 21, 22}));
}

TEST(PartnerRanking, SessionsOfOtherFamiliesHaveSeatsByTheirWallsWhicheverWayTheSensorFaced) {
  Tunnels tunnels(40, 2);  // even and odd ids
  const auto chosen = tunnels.ranking.rank(20, tunnels.sessions);
  ASSERT_EQ(chosen.size(), 6U) << "four of its family, two of the other";
  EXPECT_EQ(std::set<SessionId>(chosen.begin(), chosen.begin() + 4), (std::set<SessionId>{16, 18, 22, 24}));
  EXPECT_EQ(std::set<SessionId>(chosen.begin() + 4, chosen.end()), (std::set<SessionId>{19, 21}));
}

TEST(WallSignature, IsTheSameWhicheverWayTheSensorFacesAndNothingWhereTooLittleIsSeen) {
  Keyframe k = tunnel(4, 0.3, 1), turned = k;
  std::rotate(turned.walls.code.begin(), turned.walls.code.begin() + 50, turned.walls.code.end());
  const auto one = wall_signature(k.walls), other = wall_signature(turned.walls);
  ASSERT_TRUE(one && other);
  ASSERT_EQ(one->size(), wall_signature_size);
  for (std::size_t i = 0; i < one->size(); ++i) EXPECT_NEAR((*one)[i], (*other)[i], 0.1);  // of 57 at most
  WallProfile seen{};
  std::fill_n(seen.code.begin(), 19, std::uint8_t{100});
  EXPECT_FALSE(wall_signature(seen));
  seen.code[19] = 100;
  EXPECT_TRUE(wall_signature(seen));
}

}  // namespace
}  // namespace headframe
