// The place index over the whole database, on both sides of its switch from exact search to FLANN.
#include "server/merge/partner_ranking.hpp"

#include <gtest/gtest.h>

#include <random>

namespace headframe {
namespace {

constexpr std::size_t switches_at = 20000;  // keyframes of a family

const FamilyId family{"any", 1};

/// Sessions of keyframes whose q lie around a place of their own.
struct Database {
  SessionMap sessions{MergeConfig{}};
  PartnerRanking ranking;
  std::mt19937 rng{1};
  std::size_t size = 0;

  void add(SessionId id, std::size_t keyframes, float around) {
    sessions.add(id, family);
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
  std::vector<SessionId> rank(SessionId id) const { return ranking.rank(id, sessions); }
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
  EXPECT_EQ(database.rank(4).front(), 1) << "nobody looks like it but itself";
  database.add(5, 60, 89);
  EXPECT_EQ(database.rank(4).front(), 5) << "what came after the switch is found";
}

TEST(PartnerRanking, OtherFamiliesComeLast) {
  Database database;
  database.add(1, 5, 0);
  database.add(2, 5, 0);
  database.sessions.add(3, {"other", 1});
  database.add(4, 5, 0);
  EXPECT_EQ(database.rank(1), (std::vector<SessionId>{2, 4, 3}));
}

}  // namespace
}  // namespace headframe
